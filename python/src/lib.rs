//! The Python package `supple`: numpy arrays in and out of the engine. Nothing physical is here.
//!
//! | file | what it does |
//! |---|---|
//! | `error` | the engine's errors as Python's |
//! | `arrays` | numpy arrays in and out |
//! | `interrupt` | long work that Ctrl-C ends |
//! | `pose` | poses as SMPL has them, and the avatar's frames |
//! | `avatar` | an avatar, from files, samples and arrays |
//! | `settings` | what may be set on a simulation |
//! | `motion` | what a simulation follows |
//! | `result` | what a step and a clip give |
//! | `simulation` | avatars in time |
//! | `collider` | what they touch |
//! | `potential` | E of a step with its derivatives |

mod arrays;
mod avatar;
mod collider;
mod error;
mod interrupt;
mod motion;
mod pose;
mod potential;
mod result;
mod settings;
mod simulation;

use pyo3::prelude::*;

#[pymodule]
fn _supple(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("BAKE_PHASES", supple_bake::PHASES)?;
    module.add_class::<avatar::Avatar>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<collider::Collider>()?;
    module.add_class::<potential::Potential>()?;
    module.add_class::<result::StepResult>()?;
    module.add_class::<result::Clip>()?;
    Ok(())
}
