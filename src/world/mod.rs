//! A world: avatars of any assets, and the colliders and rigid bodies that all of them share.
//!
//! The layer for programs that have characters and want flesh on them; [`crate::sim`] is the layer below.
//!
//! | file | what is in it |
//! |---|---|
//! | `keys` | what a world calls its things by |
//! | `backend` | where the tissue is evaluated, and what evaluates one asset |
//! | `gpu` | what the evaluators on a GPU share |
//! | `evaluators` | all assets as a step sees them |
//! | `trials` | energy differences of any of them |
//! | `late_ends` | what their steps end with on the GPU |
//! | `character` | one avatar in the world |
//! | `driving` | what drives it |
//! | `pose_springs` | what keeps its bind pose where nothing does |
//! | `batch` | the instances of one asset |
//! | `near` | what an avatar may touch |
//! | `contents` | the world, its avatars and their instances |
//! | `colliders`, `bodies` | what all avatars meet |
//! | `skins` | the posed skins, for who draws them |
//! | `contacts` | what presses where on them |
//! | `meetings` | who touches what in a step |
//! | `waking` | which fine handles are awake |
//! | `step` | a step |
//! | `settle` | all characters into equilibrium |
//! | `snapshot` | all that moves, as bytes and back |

mod backend;
mod batch;
mod bodies;
mod character;
mod colliders;
mod contacts;
mod contents;
mod driving;
mod evaluators;
mod frame;
#[cfg(feature = "gpu")]
mod gpu;
mod keys;
#[cfg(feature = "gpu")]
mod late_ends;
mod meetings;
mod near;
mod pose_springs;
mod settle;
mod skins;
mod snapshot;
mod step;
mod trials;
mod waking;

pub use backend::Backend;
pub use character::{Character, Driving};
pub use contents::World;
#[cfg(feature = "gpu")]
pub use gpu::SkinBuffer;
pub use keys::{AvatarId, BodyId, ColliderId, InstanceId};
pub use snapshot::Snapshot;
pub use step::LONGEST_STEP;
