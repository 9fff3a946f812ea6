//! The step: state, Newton, the reduced system.
