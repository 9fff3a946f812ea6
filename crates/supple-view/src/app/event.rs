//! What happens to the program, whoever tells it: a window, a page, a test.

use std::path::PathBuf;

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Left.
    Primary,
    /// Right.
    Secondary,
    /// The wheel.
    Middle,
}

/// What happens. Places are pixels from the left and from above.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The cursor is here.
    Moved([f64; 2]),
    /// The cursor has left.
    Left,
    /// A button goes down or up where the cursor is.
    Button(Button, bool),
    /// The wheel turns away from the user by notches.
    Wheel(f64),
    /// A key goes down or up.
    Key(egui::Key, bool),
    /// Something is written.
    Text(String),
    /// A file is dropped.
    Dropped(PathBuf),
}

impl Event {
    /// As egui has it, where `cursor` is in points and a point has so many pixels.
    pub(super) fn for_panel(&self, cursor: egui::Pos2, scale: f32) -> Option<egui::Event> {
        let modifiers = egui::Modifiers::NONE;
        Some(match self {
            Self::Moved(place) => egui::Event::PointerMoved(points(*place, scale)),
            Self::Left => egui::Event::PointerGone,
            Self::Button(button, pressed) => egui::Event::PointerButton {
                pos: cursor,
                button: match button {
                    Button::Primary => egui::PointerButton::Primary,
                    Button::Secondary => egui::PointerButton::Secondary,
                    Button::Middle => egui::PointerButton::Middle,
                },
                pressed: *pressed,
                modifiers,
            },
            Self::Wheel(notches) => egui::Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: egui::vec2(0.0, *notches as f32),
                modifiers,
            },
            Self::Key(key, pressed) => egui::Event::Key {
                key: *key,
                physical_key: None,
                pressed: *pressed,
                repeat: false,
                modifiers,
            },
            Self::Text(text) => egui::Event::Text(text.clone()),
            Self::Dropped(_) => return None,
        })
    }
}

/// A place in points.
pub(super) fn points([x, y]: [f64; 2], scale: f32) -> egui::Pos2 {
    egui::Pos2::new(x as f32 / scale, y as f32 / scale)
}
