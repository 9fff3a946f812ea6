//! How the tissue sways on its bones: the profile that truncated rows keep, and the reduced system at rest.

mod profile;
mod rest_system;

pub(crate) use profile::SwayProfile;
pub use rest_system::{RestSystem, full_compliance, sway_frequency};
