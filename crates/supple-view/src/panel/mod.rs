//! The panel beside the scene.

mod controls;
mod paint;
mod plot;

pub use controls::{Command, Controls};
pub use paint::{Painter, Screen};

use crate::app::Pace;
use crate::bake::{Loading, Request};
use crate::stage::{Stage, ValueMap};
use crate::touch::Tool;
use egui::{Color32, RichText, Slider, Ui};
use supple_bake::PHASES;
use supple_samples::Sample;

/// Its width, points.
pub const WIDTH: f32 = 290.0;

/// What is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// A sentence, with file, field and cure where something went wrong.
    pub text: String,
    /// Whether something went wrong.
    pub wrong: bool,
}

/// What the panel tells of.
pub struct Facts<'a> {
    /// Who is shown.
    pub stage: Option<&'a Stage>,
    /// Who is on the way.
    pub loading: Option<&'a Loading>,
    /// What happened last.
    pub notice: Option<&'a Notice>,
    /// What drawing a frame and reading the skin cost the CPU lately, ms.
    pub frame: f64,
    /// Force with which the skin is held, N.
    pub pull: f64,
    /// The same as a label in the scene.
    pub label: Option<(egui::Pos2, String)>,
}

/// Lays the panel out; gives what was asked for.
pub fn show(
    context: &egui::Context,
    controls: &mut Controls,
    pace: &mut Pace,
    facts: &Facts<'_>,
) -> Vec<Command> {
    let mut asked = Vec::new();
    if let Some((at, text)) = &facts.label {
        let painter = context.layer_painter(egui::LayerId::background());
        let font = egui::FontId::proportional(15.0);
        let place = *at + egui::vec2(10.0, 0.0);
        painter.text(
            place,
            egui::Align2::LEFT_CENTER,
            text,
            font,
            Color32::from_rgb(8, 40, 80),
        );
    }
    let panel = egui::SidePanel::right("panel")
        .exact_width(WIDTH)
        .resizable(false);
    panel.show(context, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            who(ui, facts, &mut asked);
            ui.separator();
            time(ui, pace, &mut asked);
            ui.separator();
            touch(ui, controls, facts, &mut asked);
            ui.separator();
            tissue(ui, controls, facts.stage);
            ui.separator();
            values(ui, controls, facts);
            ui.separator();
            costs(ui, facts);
            ui.separator();
            files(ui, facts, &mut asked);
        });
    });
    asked
}

fn who(ui: &mut Ui, facts: &Facts<'_>, asked: &mut Vec<Command>) {
    if let Some(stage) = facts.stage {
        let character = &stage.character;
        ui.heading(&character.name);
        let avatar = &character.avatar;
        let (vertices, bones, handles) = (avatar.skin.len(), avatar.bones(), avatar.handles.len());
        ui.label(&character.does);
        ui.weak(format!(
            "vertices {vertices}, bones {bones}, handles {handles}"
        ));
        for note in &character.notes {
            ui.weak(note);
        }
    }
    if let Some(loading) = facts.loading {
        let phase = loading.phase.and_then(|p| PHASES.get(p));
        let doing = phase.map_or("getting ready", |p| p);
        let done = loading
            .phase
            .map_or(0.0, |p| (p + 1) as f32 / (PHASES.len() + 1) as f32);
        ui.label(format!(
            "{}: {doing}, {:.1} s",
            loading.name,
            loading.seconds()
        ));
        ui.add(egui::ProgressBar::new(done).desired_height(8.0));
    }
    if let Some(notice) = facts.notice {
        let colour = match notice.wrong {
            true => Color32::from_rgb(255, 120, 90),
            false => Color32::from_rgb(150, 200, 150),
        };
        ui.label(RichText::new(&notice.text).color(colour));
    }
    ui.horizontal(|ui| {
        ui.weak("Drop a file here, or show a");
        for (sample, name) in [(Sample::Hand, "hand"), (Sample::Body, "body")] {
            if ui.small_button(name).clicked() {
                asked.push(Command::Open(Request::Sample(sample)));
            }
        }
    });
}

fn time(ui: &mut Ui, pace: &mut Pace, asked: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let label = if pace.paused { "Go on" } else { "Pause" };
        if ui.button(label).on_hover_text("Space").clicked() {
            pace.paused = !pace.paused;
        }
        if ui.button("Step").on_hover_text(". (period)").clicked() {
            pace.step_once();
        }
        if ui.button("Reset").on_hover_text("R").clicked() {
            asked.push(Command::Reset);
        }
        if ui.button("Fit").on_hover_text("F").clicked() {
            asked.push(Command::Fit);
        }
    });
    ui.add(Slider::new(&mut pace.speed, 0.05..=1.0).text("speed"));
}

fn touch(ui: &mut Ui, controls: &mut Controls, facts: &Facts<'_>, asked: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        for tool in Tool::ALL {
            ui.selectable_value(&mut controls.tool, tool, tool.name());
        }
        if ui.button("throw").on_hover_text("B").clicked() {
            asked.push(Command::Throw);
        }
    });
    match controls.tool {
        Tool::Hand => {
            ui.add(
                Slider::new(&mut controls.pull, 10.0..=3000.0)
                    .logarithmic(true)
                    .text("pull, N/m"),
            );
            ui.add(Slider::new(&mut controls.grip, -5.0..=0.0).text("bones held, 10^"));
            ui.label(format!("held with {:.2} N", facts.pull));
        }
        _ => {
            ui.weak("over the skin; the wheel presses it in");
            ui.add(
                Slider::new(&mut controls.width, 0.01..=0.2)
                    .logarithmic(true)
                    .text("size"),
            );
            let force = facts.stage.map_or(0.0, |s| s.measures.last().force);
            ui.label(format!("contact {force:.2} N"));
        }
    }
}

fn tissue(ui: &mut Ui, controls: &mut Controls, stage: Option<&Stage>) {
    let c = controls;
    ui.add(
        Slider::new(&mut c.softness, 0.2..=8.0)
            .logarithmic(true)
            .text("softness"),
    );
    ui.add(Slider::new(&mut c.bounce, 0.0..=0.95).text("bounce"));
    ui.add(Slider::new(&mut c.weight, 0.0..=3.0).text("weight"));
    ui.add(Slider::new(&mut c.gravity, 0.0..=2.0).text("gravity"));
    ui.add(Slider::new(&mut c.friction, 0.0..=2.0).text("friction"));
    ui.add(Slider::new(&mut c.tension, 0.0..=1.0).text("tension"));
    if let Some(stage) = stage
        && stage.character.avatar.fine.slots > 0
    {
        let most = stage.character.avatar.fine.slots;
        let text = format!("fine handles, {} awake", stage.awake());
        ui.add(Slider::new(&mut c.fine_handles, 0..=most).text(text));
    }
    let mut ms = 1e3 * c.time_step;
    if ui
        .add(Slider::new(&mut ms, 2.0..=17.0).text("step, ms"))
        .changed()
    {
        c.time_step = 1e-3 * ms;
    }
}

fn values(ui: &mut Ui, controls: &mut Controls, facts: &Facts<'_>) {
    egui::ComboBox::from_id_salt("map")
        .selected_text(controls.map.name())
        .show_ui(ui, |ui| {
            for map in ValueMap::ALL {
                ui.selectable_value(&mut controls.map, map, map.name());
            }
        });
    if let Some(stage) = facts.stage.filter(|_| controls.map != ValueMap::None) {
        let (unit, factor) = controls.map.unit();
        plot::legend(ui, &format!("{:.1} {unit}", factor * stage.shown.most));
    }
    ui.horizontal(|ui| {
        ui.checkbox(&mut controls.handles, "handles");
        ui.checkbox(&mut controls.colliders, "colliders");
    });
}

fn costs(ui: &mut Ui, facts: &Facts<'_>) {
    let Some(stage) = facts.stage else { return };
    let samples = || stage.measures.samples();
    plot::lines(ui, "N", samples().map(|s| (s.time, s.force.max(s.pull))));
    plot::lines(ui, "mm", samples().map(|s| (s.time, 1e3 * s.displacement)));
    let (times, last) = (stage.timings(), stage.measures.last());
    ui.label(format!(
        "step {:.1} ms, frame {:.1} ms",
        times.step, facts.frame
    ));
    ui.weak(format!(
        "evaluation {:.1}, skeleton {:.1}, solve {:.1}, skin {:.1} ms; {} iterations, {} contacts",
        times.evaluation, times.skeleton, times.solve, times.skin, last.iterations, last.contacts
    ));
    ui.weak(format!("on {}", stage.world.backend()));
}

fn files(ui: &mut Ui, facts: &Facts<'_>, asked: &mut Vec<Command>) {
    let Some(stage) = facts.stage else { return };
    ui.horizontal_wrapped(|ui| {
        let buttons = [
            (
                "GLB of the last 20 s",
                Command::WriteGlb,
                !stage.record.is_empty(),
            ),
            ("recipe", Command::WriteRecipe, true),
            ("keep this moment", Command::Keep, true),
            ("back to it", Command::Restore, stage.has_kept()),
        ];
        for (label, command, usable) in buttons {
            if ui.add_enabled(usable, egui::Button::new(label)).clicked() {
                asked.push(command);
            }
        }
    });
}
