//! A run's report as a table.

use super::terminal::{print_table, tell};
use supple_scene::Report;

/// Says on stderr what no body would survive: the run ended, but its results mean little.
pub fn warn_of_the_implausible(r: &Report) {
    /// Beyond this a joint is torn, mm.
    const TORN: f64 = 10.0;
    if let Some(det) = r.min_det_f.filter(|det| *det <= 0.0) {
        tell(format_args!(
            "warning: tets were inverted (smallest det F {det:.3}): more handles in the volume, or a gentler press, would help"
        ));
    }
    if r.max_joint_gap_mm > TORN {
        tell(format_args!(
            "warning: a joint came apart by {:.1} mm: a target may be out of reach, or the joint_stiffness too low",
            r.max_joint_gap_mm
        ));
    }
}

/// Writes the table of what was shown and not pressed.
pub fn print_play(r: &Report) {
    let times = &r.ms_per_step;
    print_table([
        ("backend", format!("{} ({})", r.backend, r.adapter)),
        ("steps", format!("{} of {} s", r.steps, r.time_step)),
        ("degrees of freedom", degrees_of_freedom(r)),
        (
            "ms a step",
            format!("{:.3} median, {:.3} p95", times.median, times.p95),
        ),
        (
            "tissue off the skinned shape",
            format!("{:.3} mm at most", r.max_unposed_displacement_mm),
        ),
        ("smallest det F", smallest_det_f(r)),
        ("into the ground", format!("{:.3} mm", r.max_penetration_mm)),
        ("joint gap", format!("{:.4} mm", r.max_joint_gap_mm)),
    ]);
}

fn degrees_of_freedom(r: &Report) -> String {
    match r.fine_handles {
        0 => format!("{} ({} handles)", r.dofs, r.handles),
        fine => format!(
            "{} ({} handles, up to {fine} fine ones awake)",
            r.dofs, r.handles
        ),
    }
}

fn smallest_det_f(r: &Report) -> String {
    let unknown = "not known: baked without its layer";
    (r.min_det_f).map_or(unknown.into(), |det| format!("{det:.3}"))
}

/// Writes the table.
pub fn print_report(r: &Report) {
    let ms = &r.breakdown_ms;
    print_table([
        ("backend", format!("{} ({})", r.backend, r.adapter)),
        ("steps", format!("{} of {} s", r.steps, r.time_step)),
        ("degrees of freedom", degrees_of_freedom(r)),
        ("cubature points", r.cubature_points.to_string()),
        (
            "ms a step",
            format!(
                "{:.3} median, {:.3} p95",
                r.ms_per_step.median, r.ms_per_step.p95
            ),
        ),
        (
            "medians of parts",
            format!(
                "evaluation {:.3} (force {:.3}, Hessian {:.3}, readback {:.3}), solve {:.3}, skin {:.3}, \
                 skeleton {:.3}",
                ms.evaluation, ms.force, ms.hessian, ms.readback, ms.solve, ms.skin, ms.skeleton
            ),
        ),
        ("smallest det F", smallest_det_f(r)),
        ("penetration", format!("{:.3} mm", r.max_penetration_mm)),
        ("joint gap", format!("{:.4} mm", r.max_joint_gap_mm)),
        (
            "unposed displacement",
            format!(
                "{:.3} mm at most, {:.3} mm at full press",
                r.max_unposed_displacement_mm, r.full_press_displacement_mm
            ),
        ),
        (
            "residual displacement",
            format!("{:.5} mm", r.residual_displacement_mm),
        ),
    ]);
    if r.first_contact_s.is_some() {
        print_table([
            (
                "at full press",
                format!(
                    "{:.3} N of contact, {:.3} N borne by targets and pins",
                    r.contact_force_n, r.load_n
                ),
            ),
            (
                "ms a step in contact",
                format!("{:.3} median", r.ms_per_step_in_contact.median),
            ),
        ]);
    }
}
