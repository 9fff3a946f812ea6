//! The f64 evaluation of the potential: the twin of the kernels, and the fallback where there is no GPU.
