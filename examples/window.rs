//! A character in a window of the host's own renderer. Its skin is pulled from where the world posed it, with the seams and
//! base colours of its file. Drag to turn, scroll to come near; M shows motion vectors.
//!
//!     cargo run --release --example window -- character.glb
//!     cargo run --release --example window -- character.glb --cpu      # steps on the CPU, and uploads the skin
//!     cargo run --release --example window -- character.glb --picture out/window.png   # no window; --motion for vectors

mod renderer;

use renderer::{Camera, Renderer, Upload, open_window, write_picture};
use std::path::PathBuf;
use supple::glam::{DVec3, Mat4};
use supple::model::Avatar;
use supple::wgpu;
use supple::world::{Backend, InstanceId};
use supple::{Result, World};
use supple_files::{
    CharacterOptions, ClipOptions, ClipPlayer, RetargetOptions, read_character, read_gltf_motions,
};

type Anything<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Anything<()> {
    let arguments = Arguments::read()?;
    let character = Character::bake(&arguments)?;
    let Some(path) = &arguments.picture else {
        return open_window(arguments, character);
    };
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let host = pollster::block_on(Host::open(&instance, None))?;
    let mut stage = Stage::new(&character, host.backend(&arguments))?;
    let mut renderer = host.renderer(renderer::PICTURE_FORMAT, &arguments, &character);
    let mut upload = Upload::new(&host.device, character.avatar.skin.len());
    let mut camera = stage.camera()?;
    for _ in 0..45 {
        stage.step(1.0 / 60.0)?;
    }
    camera.target = stage.target()?;
    let posed = upload.posed(&host.queue, &mut stage.world, stage.me)?;
    println!("on {}", stage.world.backend());
    write_picture(&mut renderer, &posed, &camera, path)
}

/// What was asked for.
struct Arguments {
    character: PathBuf,
    picture: Option<PathBuf>,
    cpu: bool,
    motion: bool,
}

impl Arguments {
    fn read() -> Anything<Self> {
        let mut arguments = std::env::args().skip(1);
        let mut read = Self {
            character: PathBuf::new(),
            picture: None,
            cpu: false,
            motion: false,
        };
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--cpu" => read.cpu = true,
                "--motion" => read.motion = true,
                "--picture" => {
                    let path = arguments.next().ok_or("--picture wants a path")?;
                    read.picture = Some(path.into());
                }
                path => read.character = path.into(),
            }
        }
        match read.character.as_os_str().is_empty() {
            false => Ok(read),
            true => Err("name a glTF file with a clip".into()),
        }
    }
}

/// A character of a file, baked, and its first clip.
struct Character {
    avatar: Avatar,
    player: ClipPlayer,
}

impl Character {
    fn bake(arguments: &Arguments) -> Anything<Self> {
        let path = &arguments.character;
        let file = read_character(path, &CharacterOptions::default())?;
        let recipe = supple_bake::Recipe::default();
        let (avatar, _) = supple_bake::bake(&file.body, &recipe, &mut |_| {})?;
        let clip = read_gltf_motions(path)?.into_iter().next();
        let options = ClipOptions {
            retarget: RetargetOptions {
                avatar_up: Some(avatar.up),
                up: DVec3::Y,
                ..RetargetOptions::default()
            },
            repeat: true,
            ..ClipOptions::default()
        };
        let clip = clip.ok_or("the file has no clip")?;
        let player = ClipPlayer::new(clip, &avatar.skeleton, &options)?;
        Ok(Self { avatar, player })
    }
}

/// The device of the host.
struct Host {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Host {
    /// A device that can draw on `surface` and has what the world's kernels need.
    async fn open(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Anything<Self> {
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                compatible_surface: surface,
                ..Default::default()
            })
            .await?;
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                required_features: supple::gpu::required_features(),
                required_limits: supple::gpu::required_limits(),
                ..Default::default()
            })
            .await?;
        Ok(Self {
            adapter,
            device,
            queue,
        })
    }

    fn backend(&self, arguments: &Arguments) -> Backend {
        match arguments.cpu {
            true => Backend::Cpu,
            false => Backend::Gpu {
                device: self.device.clone(),
                queue: self.queue.clone(),
            },
        }
    }

    fn renderer(
        &self,
        format: wgpu::TextureFormat,
        arguments: &Arguments,
        character: &Character,
    ) -> Renderer {
        let gpu = (&self.device, &self.queue);
        let mut renderer = Renderer::new(gpu, format, &character.avatar, &arguments.character);
        renderer.shows_motion = arguments.motion;
        renderer
    }
}

/// The character in a world, following its clip.
struct Stage {
    world: World,
    me: InstanceId,
    player: ClipPlayer,
    matrices: Vec<Mat4>,
    /// s.
    time: f64,
}

impl Stage {
    fn new(character: &Character, backend: Backend) -> Result<Self> {
        let mut world = World::new(backend)?;
        let avatar = &character.avatar;
        let mut player = character.player.clone();
        player.stand_at(&avatar.placed(&avatar.standing(world.up())).frames);
        let me = world.add_avatar(avatar.clone())?;
        let me = world.add_instance(me)?;
        world.add_ground()?;
        let mut stage = Self {
            world,
            me,
            player,
            matrices: Vec::new(),
            time: 0.0,
        };
        stage.follow()?;
        Ok(stage)
    }

    /// Hands over the joints' matrices, which a game's animation gives: here the clip does.
    fn follow(&mut self) -> Result<()> {
        let frames = self.player.frames(self.time);
        let me = self.world.instance_mut(self.me)?;
        let joints = &me.avatar().joints;
        joints.joint_matrices(&frames, &mut self.matrices)?;
        me.follow_world(&self.matrices)
    }

    fn step(&mut self, time_step: f64) -> Result<()> {
        self.time += time_step;
        self.follow()?;
        self.world.step_blocking(time_step)
    }

    /// What the camera looks at, m.
    fn target(&self) -> Result<DVec3> {
        let frames = self.world.instance(self.me)?.frames();
        Ok(frames.iter().map(|f| f.position).sum::<DVec3>() / frames.len() as f64)
    }

    /// A camera that sees all of the character.
    fn camera(&mut self) -> Result<Camera> {
        let (mut skin, mut normals) = (Vec::new(), Vec::new());
        self.world
            .read_skin_blocking(self.me, &mut skin, &mut normals)?;
        let low = skin.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = skin.iter().copied().reduce(DVec3::max).unwrap_or_default();
        Ok(Camera {
            target: self.target()?,
            angles: [0.6, 0.2],
            distance: 1.9 * (high - low).length() as f32,
        })
    }
}
