//! Small plots, and the key of a colour map.

use crate::stage::Measures;
use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, vec2};
use supple_pictures::colour_map;

/// The least that fills a plot, N or mm: less is noise.
const LEAST: f64 = 0.1;

/// A curve of the last seconds: times (s) and values, from 0 to the largest.
pub fn lines(ui: &mut Ui, unit: &str, points: impl Iterator<Item = (f64, f64)> + Clone) {
    let size = vec2(ui.available_width(), 44.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let most = points.clone().map(|p| p.1).fold(LEAST, f64::max);
    let now = points.clone().last().map_or(0.0, |p| p.0);
    let place = |(time, value): (f64, f64)| {
        let x = 1.0 - (now - time) / Measures::span();
        let inner = rect.shrink(3.0);
        let (x, y) = (
            x.clamp(0.0, 1.0) as f32,
            (value / most).clamp(0.0, 1.0) as f32,
        );
        Pos2::new(
            inner.left() + x * inner.width(),
            inner.bottom() - y * inner.height(),
        )
    };
    let stroke = Stroke::new(1.2, Color32::from_rgb(240, 160, 90));
    painter.line(points.map(place).collect(), stroke);
    let (font, colour) = (FontId::proportional(10.0), ui.visuals().weak_text_color());
    let text = format!("{most:.2} {unit}");
    painter.text(
        rect.left_top() + vec2(4.0, 2.0),
        Align2::LEFT_TOP,
        text,
        font,
        colour,
    );
}

/// The colours from nothing to `most`.
pub fn legend(ui: &mut Ui, most: &str) {
    let size = vec2(ui.available_width(), 14.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    const STEPS: usize = 48;
    for k in 0..STEPS {
        let share = |k: usize| rect.left() + rect.width() * k as f32 / STEPS as f32;
        let [r, g, b] = colour_map((k as f64 + 0.5) / STEPS as f64);
        let part = Rect::from_x_y_ranges(share(k)..=share(k + 1), rect.y_range());
        let colour = egui::Rgba::from_rgb(r, g, b);
        ui.painter().rect_filled(part, 0.0, colour);
    }
    ui.horizontal(|ui| {
        ui.weak("0");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.weak(most)
        });
    });
}
