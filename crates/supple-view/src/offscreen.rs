//! The program without a window: for pictures and tests.

use crate::app::{App, Event, Options};
use crate::bake::Request;
use crate::draw::{Gpu, PICTURE_FORMAT, Picture, picture};
use crate::panel::Screen;
use crate::platform::rest;
use supple::{Error, Result};

/// The program, drawn on a texture.
pub struct Offscreen {
    /// It.
    pub app: App,
    gpu: Gpu,
    size: [u32; 2],
}

/// From frame to frame, s.
const FRAME: f64 = 1.0 / 60.0;

impl Offscreen {
    /// Pictures of this size.
    ///
    /// # Errors
    /// No adapter; a software one will do.
    pub fn open(options: Options, size: [u32; 2]) -> Result<Self> {
        let gpu = pollster::block_on(Gpu::open_without_window())?;
        Ok(Self {
            app: App::new(&gpu, PICTURE_FORMAT, options),
            gpu,
            size,
        })
    }

    /// Shows `request`, and waits until it is there.
    ///
    /// # Errors
    /// What reading and baking say.
    pub fn show(&mut self, request: Request) -> Result<()> {
        self.app.open(request);
        self.wait();
        match self.app.notice().filter(|notice| notice.wrong) {
            Some(notice) => Err(Error::invalid("character", notice.text.clone())),
            None => Ok(()),
        }
    }

    /// Waits until nobody is on the way any more.
    pub fn wait(&mut self) {
        while self.app.is_loading() {
            rest();
            pollster::block_on(self.app.advance(0.0));
        }
    }

    /// Something happens.
    pub fn handle(&mut self, event: Event) {
        self.app.handle(&event);
    }

    /// Lets `seconds` pass, sixty frames a second, without drawing.
    pub fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / FRAME).round() as usize {
            pollster::block_on(self.app.advance(FRAME));
        }
    }

    /// A picture of what is shown now.
    ///
    /// # Errors
    /// A lost device.
    pub fn picture(&mut self) -> Result<Picture> {
        let screen = Screen {
            size: self.size,
            scale: 1.0,
        };
        let app = &mut self.app;
        pollster::block_on(picture(&self.gpu, self.size, |target| {
            app.draw(target, screen);
            Ok(())
        }))
    }
}
