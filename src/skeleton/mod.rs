//! Energies of the bones: joints, bending stiffness, tracking, their own inertia and weight. Assembled in f64.
