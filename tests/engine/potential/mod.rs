//! The potential: its derivatives, both evaluations, and each kernel against its twin.

mod cpu;
mod derivatives;
mod energies;
#[cfg(feature = "gpu")]
mod fxc;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "gpu")]
mod kernels;
#[cfg(feature = "gpu")]
mod layout;
#[cfg(feature = "gpu")]
mod mutants;
#[cfg(feature = "gpu")]
mod parity;
