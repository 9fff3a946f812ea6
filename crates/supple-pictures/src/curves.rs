//! Curves as SVG.

use super::axis::Extent;
use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use supple::{Error, Result};

/// A line through points.
#[derive(Clone, Debug)]
pub struct Series {
    /// What it is.
    pub name: String,
    /// (x, y), in the axes' units.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub mark: Mark,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// A line: the record of a run.
    #[default]
    Line,
    /// Dots joined by a line: measurements that depend on x.
    JoinedDots,
    /// Dots alone: events.
    Dots,
}

/// How an axis is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By powers of ten; points at or below 0 are left out.
    Logarithmic,
}

/// Curves over one pair of axes.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// What they show.
    pub title: String,
    /// Name of the horizontal axis, with its unit.
    pub x: String,
    /// Name of the vertical axis, with its unit.
    pub y: String,
    /// The lines.
    pub series: Vec<Series>,
    /// Of the horizontal axis.
    pub x_scale: Scale,
    /// Of the vertical axis.
    pub y_scale: Scale,
}

impl Curves {
    /// Axes without lines.
    pub fn new(title: &str, x: &str, y: &str) -> Self {
        Self {
            title: title.into(),
            x: x.into(),
            y: y.into(),
            ..Self::default()
        }
    }

    /// With a line.
    pub fn line(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.with(name, points, Mark::Line)
    }

    /// With a line and a dot at each of its points.
    pub fn dots(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.with(name, points, Mark::JoinedDots)
    }

    /// With dots alone.
    pub fn events(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.with(name, points, Mark::Dots)
    }

    fn with(
        mut self,
        name: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
        mark: Mark,
    ) -> Self {
        self.series.push(Series {
            name: name.into(),
            points: points.into_iter().collect(),
            mark,
        });
        self
    }

    /// With the vertical axis divided by powers of ten.
    pub fn logarithmic(mut self) -> Self {
        self.y_scale = Scale::Logarithmic;
        self
    }

    /// The chart, on white, 720 × 400 or wider by its legend, which stands beside it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is nothing to draw.
    pub fn svg(&self) -> Result<String> {
        let shown = |s: &Series| -> Vec<(f64, f64)> {
            let fits = |v: f64, scale| v.is_finite() && (scale == Scale::Linear || v > 0.0);
            let points = s.points.iter().copied();
            points
                .filter(|p| fits(p.0, self.x_scale) && fits(p.1, self.y_scale))
                .collect()
        };
        let lines: Vec<Vec<(f64, f64)>> = self.series.iter().map(shown).collect();
        let (Some(mut x), Some(mut y)) = (
            Extent::of(lines.iter().flatten().map(|p| p.0), self.x_scale),
            Extent::of(lines.iter().flatten().map(|p| p.1), self.y_scale),
        ) else {
            let problem = "no point of it can be drawn";
            return Err(Error::invalid(format!("curves {:?}", self.title), problem));
        };
        y.reach_zero();
        x.widen();
        y.widen();
        let mut out = String::new();
        let drawn = {
            let size = (FINE * self.width(), FINE * 400);
            let area = SVGBackend::with_string(&mut out, (size.0 as u32, size.1 as u32))
                .into_drawing_area();
            let line = |e: Extent| RangedCoordf64::from(e.low..e.high);
            let powers = |e: Extent| (e.low..e.high).log_scale().with_key_points(e.marks());
            match (self.x_scale, self.y_scale) {
                (Scale::Linear, Scale::Linear) => {
                    self.draw(&area, (x, line(x)), (y, line(y)), &lines)
                }
                (Scale::Linear, Scale::Logarithmic) => {
                    self.draw(&area, (x, line(x)), (y, powers(y)), &lines)
                }
                (Scale::Logarithmic, Scale::Linear) => {
                    self.draw(&area, (x, powers(x)), (y, line(y)), &lines)
                }
                (Scale::Logarithmic, Scale::Logarithmic) => {
                    self.draw(&area, (x, powers(x)), (y, powers(y)), &lines)
                }
            }
        };
        drawn.map_err(|e| Error::invalid(format!("curves {:?}", self.title), e))?;
        Ok(out)
    }

    /// How wide the chart is with its legend, where it is 400 high.
    pub fn width(&self) -> i32 {
        720 + self.legend_width()
    }

    /// Room beside the chart for the series' names; one line needs none.
    fn legend_width(&self) -> i32 {
        let longest = self.series.iter().map(|s| s.name.chars().count()).max();
        match longest {
            Some(letters) if self.series.len() > 1 => 44 + 7 * letters as i32,
            _ => 0,
        }
    }

    fn draw<X, Y>(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        (x_extent, x): (Extent, X),
        (y_extent, y): (Extent, Y),
        lines: &[Vec<(f64, f64)>],
    ) -> Result<(), String>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let told = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        area.fill(&WHITE).map_err(told)?;
        let font = |size: i32| ("sans-serif", FINE * size);
        let stroke = |colour: RGBColor| colour.stroke_width(2 * FINE as u32);
        let (plot, legend) = area.split_horizontally(FINE * 720);
        let mut chart = ChartBuilder::on(&plot)
            .margin(FINE * 12)
            .x_label_area_size(FINE * 44)
            .y_label_area_size(FINE * 70)
            .caption(&self.title, font(17))
            .build_cartesian_2d(x, y)
            .map_err(told)?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&|v| x_extent.label(*v))
            .y_label_formatter(&|v| y_extent.label(*v))
            .max_light_lines(0)
            .bold_line_style(BLACK.mix(0.13).stroke_width(FINE as u32))
            .axis_style(BLACK.mix(0.6).stroke_width(FINE as u32))
            .set_all_tick_mark_size(FINE * 5)
            .axis_desc_style(font(14))
            .label_style(font(13))
            .draw()
            .map_err(told)?;
        for (k, (series, points)) in self.series.iter().zip(lines).enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let (left, middle) = (FINE * 4, FINE * (48 + 20 * k as i32));
            if series.mark != Mark::Dots {
                let line = LineSeries::new(points.iter().copied(), stroke(colour));
                chart.draw_series(line).map_err(told)?;
            }
            if series.mark != Mark::Line {
                let dot = |p: &(f64, f64)| Circle::new(*p, 4 * FINE, colour.filled());
                chart.draw_series(points.iter().map(dot)).map_err(told)?;
            }
            if self.series.len() < 2 {
                continue;
            }
            if series.mark != Mark::Dots {
                let ends = [(left, middle), (left + FINE * 18, middle)];
                let line = PathElement::new(ends, stroke(colour));
                legend.draw(&line).map_err(told)?;
            }
            if series.mark != Mark::Line {
                let dot = Circle::new((left + FINE * 9, middle), 4 * FINE, colour.filled());
                legend.draw(&dot).map_err(told)?;
            }
            let place = (left + FINE * 25, middle - FINE * 7);
            let name = Text::new(series.name.clone(), place, font(13));
            legend.draw(&name).map_err(told)?;
        }
        area.present().map_err(told)
    }
}

/// The backend rounds to whole units: a unit is so many times smaller than a pixel.
const FINE: i32 = 4;

/// Told apart by everyone (Okabe and Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_drawn_is_drawn() {
        let points = [(0.0, 1e-6), (1.0, f64::NAN), (2.0, 0.0), (3.0, 1e-2)];
        let curves = Curves::new("error & time", "s", "m")
            .dots("a", points)
            .events("b", [(1.0, 1e-4)]);
        for curves in [curves.clone(), curves.logarithmic()] {
            let svg = curves.svg().unwrap();
            assert!(svg.starts_with("<svg") && svg.contains("error &amp; time"));
            assert!(!svg.contains("NaN"), "{svg}");
        }
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let nothing = Curves::new("nothing", "s", "m").line("a", [(f64::NAN, 1.0)]);
        assert!(nothing.svg().unwrap_err().to_string().contains("nothing"));
    }
}
