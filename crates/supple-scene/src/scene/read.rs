//! TOML to scenes.

use super::shape::mesh_files;
use super::{PanelTime, Scene};
use serde::de::DeserializeOwned;
use std::path::Path;
use supple::collider::Collider;
use supple::model::UpAxis;
use supple::{Error, Result};
use supple_files::read_toml_text;
use toml::Value;

/// Reads the scene at `path`; files that it names lie relative to it.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read, [`Error::Format`] with line or key where it is broken.
pub fn read_scene(path: impl AsRef<Path>) -> Result<Scene> {
    let path = path.as_ref();
    parse(
        &read_toml_text(path)?,
        path,
        Some(path.parent().unwrap_or(Path::new(""))),
    )
}

/// Reads a scene from `text`; `path` names it in errors. It opens no file: paths stay as they are written.
///
/// # Errors
/// As [`read_scene`], and [`Error::Format`] of a collider or body that is a mesh: its file must be read.
pub fn parse_scene(text: &str, path: &Path) -> Result<Scene> {
    parse(text, path, None)
}

/// The scene that `text` says, with what it leaves out; files lie in `folder`, or none is opened.
fn parse(text: &str, path: &Path, folder: Option<&Path>) -> Result<Scene> {
    let mut table = checked_table(text, path)?;
    let mut meshes = false;
    for (key, file) in mesh_files(&mut table) {
        meshes = true;
        match folder {
            Some(folder) => *file = folder.join(&*file).to_string_lossy().into_owned(),
            None => {
                let problem = format!(
                    "{file} was not read: read_scene reads a scene's meshes, parse_scene opens no file"
                );
                return Err(Error::format(path, key, problem));
            }
        }
    }
    let viewed = (table.get("output")).is_some_and(|output| output.get("view").is_some());
    // Text that is parsed twice tells the line of an error; a table that was changed cannot.
    let mut scene: Scene = match meshes {
        false => toml::from_str(text).map_err(|e| broken(text, path, &e))?,
        true => (table.try_into()).map_err(|e: toml::de::Error| broken(text, path, &e))?,
    };
    if scene.measure.full_press == f64::INFINITY {
        scene.measure.full_press = scene.duration();
    }
    if !viewed {
        scene.output.view = UpAxis::Z.rotation_to(scene.up()) * scene.output.view;
    }
    if scene.output.panels.is_empty() {
        scene.output.panels = scene.default_panels();
    }
    if let Some(folder) = folder {
        scene.avatar.resolve(folder);
        if let Some(motion) = &mut scene.motion {
            motion.resolve(folder);
        }
    }
    scene.validate().map_err(|e| e.of_file(path))?;
    Ok(scene)
}

/// Reads any TOML text whose numbers must be finite.
pub(crate) fn parse_toml<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T> {
    checked_table(text, path)?;
    toml::from_str(text).map_err(|e| broken(text, path, &e))
}

/// What `text` says, all numbers finite.
fn checked_table(text: &str, path: &Path) -> Result<toml::Table> {
    let table = Value::Table(toml::from_str(text).map_err(|e| broken(text, path, &e))?);
    if let Some(key) = not_finite(&table, String::new()) {
        return Err(Error::format(path, key, "is not a finite number"));
    }
    match table {
        Value::Table(table) => Ok(table),
        _ => Ok(toml::Table::new()),
    }
}

fn broken(text: &str, path: &Path, e: &toml::de::Error) -> Error {
    let line = (e.span()).map_or(1, |s| 1 + text[..s.start].matches('\n').count());
    Error::format(path, format!("line {line}"), e.message())
}

/// The key of the first number that is NaN or infinite.
fn not_finite(value: &Value, key: String) -> Option<String> {
    match value {
        Value::Float(f) if !f.is_finite() => Some(key),
        Value::Array(items) => {
            let mut items = items.iter().enumerate();
            items.find_map(|(i, v)| not_finite(v, format!("{key}[{i}]")))
        }
        Value::Table(table) => table.iter().find_map(|(name, v)| {
            let dot = if key.is_empty() { "" } else { "." };
            not_finite(v, format!("{key}{dot}{name}"))
        }),
        _ => None,
    }
}

impl Scene {
    /// Pictures of a scene that asks for none: settled, at full press, and at the end.
    fn default_panels(&self) -> Vec<PanelTime> {
        let panel = |time: f64| PanelTime::new(time, format!("{time:.2} s"));
        let mut times = vec![
            self.measure.settled,
            self.measure.full_press,
            self.duration(),
        ];
        times.dedup();
        times.into_iter().map(panel).collect()
    }

    /// Checks every number that needs no avatar to be judged; NaN never gets here.
    pub fn validate(&self) -> Result<()> {
        const MOST_STEPS: usize = 10_000_000;
        let check = |ok: bool, field: String, problem: &str| match ok {
            true => Ok(()),
            false => Err(Error::invalid(field, problem)),
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
        check(
            !self.name.is_empty() && self.name.chars().all(plain),
            "name".into(),
            "names a folder: use letters, digits, - and _",
        )?;
        check(
            (1..=MOST_STEPS).contains(&self.steps),
            "steps".into(),
            "must be 1 to 10,000,000",
        )?;
        self.settings.validate()?;
        if let Some(material) = &self.material {
            material.validate()?;
        }
        check(
            self.damping_time.is_none_or(|b| b >= 0.0),
            "damping_time".into(),
            "must be zero or positive (s)",
        )?;
        for (i, pin) in self.pins.iter().enumerate() {
            pin.motion.validate(&format!("pins[{i}].motion"))?;
        }
        for (i, target) in self.targets.iter().enumerate() {
            target.motion.validate(&format!("targets[{i}].motion"))?;
            let positive = |s: &supple::skeleton::Spring| s.stiffness >= 0.0 && s.damping >= 0.0;
            check(
                positive(&target.position) && positive(&target.rotation),
                format!("targets[{i}]"),
                "stiffness and damping must be zero or positive",
            )?;
        }
        if let Some(motion) = &self.motion {
            motion.validate()?;
        }
        for (i, collider) in self.colliders.iter().enumerate() {
            let field = format!("colliders[{i}]");
            collider.motion.validate(&format!("{field}.motion"))?;
            (collider.shape.validate()).map_err(|e| e.within("shape").within(&field))?;
            check(
                collider.stiffness.is_none_or(|k| k > 0.0),
                format!("{field}.stiffness"),
                "must be positive (Pa/m); without it the tissue's own is taken",
            )?;
            check(
                collider.margin >= 0.0,
                format!("{field}.margin"),
                "must be zero or positive (m)",
            )?;
            check(
                (0.0..=Collider::MOST_FRICTION).contains(&collider.friction),
                format!("{field}.friction"),
                "must be 0 to 10 (no unit)",
            )?;
        }
        for (i, key) in self.limits.iter().enumerate() {
            key.range(&format!("limits[{i}]"))?;
        }
        for (i, body) in self.bodies.iter().enumerate() {
            let of_body = |e: Error| e.within(&format!("bodies[{i}]"));
            let mass = body.mass.unwrap_or(1.0);
            check(
                mass > 0.0,
                format!("bodies[{i}].mass"),
                "must be positive (kg)",
            )?;
            let solid = body.rigid_body().map_err(of_body)?;
            solid.collider(0).validate().map_err(of_body)?;
        }
        let within = |time: f64| (0.0..=self.duration() * (1.0 + 1e-9)).contains(&time);
        let times = [
            ("settled", self.measure.settled),
            ("full_press", self.measure.full_press),
        ];
        for (name, time) in times {
            let field = format!("measure.{name}");
            check(within(time), field, "must lie within the run (s)")?;
        }
        for (i, panel) in self.output.panels.iter().enumerate() {
            let field = format!("output.panels[{i}].time");
            check(within(panel.time), field, "must lie within the run (s)")?;
            check(
                panel.focus.is_none_or(|f| f.radius > 0.0),
                format!("output.panels[{i}].focus.radius"),
                "must be positive (m)",
            )?;
            check(
                panel.view.is_none_or(|v| v.length() > 0.0)
                    && (panel.inset).is_none_or(|i| {
                        let up = i.up.unwrap_or_else(|| i.view.any_orthogonal_vector());
                        i.view.cross(up).length() > 0.0
                    }),
                format!("output.panels[{i}]"),
                "its view, and its inset's, must be directions that have a length, not that of up",
            )?;
        }
        let [width, height] = self.output.panel_size;
        check(
            (16..=4096).contains(&width) && (16..=4096).contains(&height),
            "output.panel_size".into(),
            "must be 16 to 4096 pixels each way",
        )?;
        check(
            self.output.record_every > 0,
            "output.record_every".into(),
            "must be at least 1",
        )?;
        check(
            self.output.view.length() > 0.0
                && self.output.cut.is_none_or(|c| c.normal.length() > 0.0),
            "output".into(),
            "a direction has no length",
        )?;
        check(
            self.output.legend_mm.is_none_or(|l| l > 0.0),
            "output.legend_mm".into(),
            "must be positive",
        )
    }
}
