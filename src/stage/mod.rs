//! One typed wrapper a kernel, and the evaluation of the potential made of them.
