//! What is asked for once.

use super::App;
use crate::draw::Camera;
use crate::panel::{Command, Notice};
use supple::internal::write_whole;
use supple::{Error, Result};

impl App {
    /// Asks for something, which is done before the next step.
    pub fn ask(&mut self, command: Command) {
        self.commands.push(command);
    }

    pub(super) async fn obey(&mut self, command: Command) -> Result<()> {
        if let Command::Open(request) = command {
            self.open(request);
            return Ok(());
        }
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        match command {
            Command::Open(_) => {}
            Command::Reset => {
                stage.reset().await?;
                self.forget_touch();
            }
            Command::Restore => {
                if stage.has_kept() {
                    stage.restore().await?;
                    (self.grab, self.probe) = (None, None);
                    self.balls = self.kept.clone();
                }
            }
            Command::Keep => {
                // What is on the cursor is no part of it.
                if let Some(probe) = self.probe.take() {
                    probe.remove(stage)?;
                }
                stage.keep()?;
                self.kept = self.balls.clone();
                self.say("this moment is kept".into());
            }
            Command::Fit => self.camera = Camera::around(stage.bounds(), stage.world.up()),
            Command::Throw => {
                let aspect = self.aspect();
                let at = self.pointer.scene(self.scene_size()).unwrap_or_default();
                let ray = self.camera.ray(at, aspect);
                if let Some(stage) = &mut self.stage {
                    let away = self.camera.distance;
                    self.balls.throw(stage, &ray, away, self.size)?;
                }
            }
            Command::WriteGlb => {
                let path = self.output("glb")?;
                if let Some(stage) = &self.stage {
                    let written = stage.record.write_glb(&stage.character.avatar, &path)?;
                    let (path, size) = (path.display(), written.bytes / 1024);
                    self.say(format!("{path}: {size} KiB"));
                }
            }
            Command::WriteRecipe => {
                let path = self.output("toml")?;
                if let Some(stage) = &self.stage {
                    let text = stage.character.scene.avatar.to_toml()?;
                    write_whole(&path, text)?;
                    self.say(format!("{}", path.display()));
                }
            }
        }
        Ok(())
    }

    /// The world has been put back: what was held and thrown is gone.
    fn forget_touch(&mut self) {
        (self.grab, self.probe) = (None, None);
        self.balls.forget();
    }

    fn say(&mut self, text: String) {
        self.notice = Some(Notice { text, wrong: false });
    }

    /// A file to be written, in a folder that is there.
    fn output(&self, extension: &str) -> Result<std::path::PathBuf> {
        let folder = &self.options.output;
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        let name = self
            .stage
            .as_ref()
            .map_or("avatar", |s| s.character.name.as_str());
        Ok(folder.join(format!("{name}.{extension}")))
    }
}
