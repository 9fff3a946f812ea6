// Points, what moves them, and the state of what moves them (method §1).

struct Point {
    position: vec3<f32>,   // X
    measure: f32,          // cubature weight (m³) or area (m²)
    first_influence: u32,  // its bones, then its handles
    bones: u32,
    handles: u32,
    first_gradient: u32,
    first_block: u32,      // its blocks (c, ω of each bone; φ of each handle) among all points'
    first_pair: u32,       // its pairs of blocks among all points'
    first_share: u32,      // what it follows of the skin's offsets, among the influences
    shares: u32,
    contact_stiffness: f32, // of a skin vertex: k of the tissue under it, Pa/m
}

struct Influence {
    index: u32,            // bone, handle or skin vertex
    weight: f32,           // w, U or E
}

struct HandleGradient {
    gradient: vec3<f32>,   // ∇U
    handle: u32,
}

struct Frame {
    rotation: mat3x3<f32>,            // R
    rotation_increment: mat3x3<f32>,  // R − R_base
    position: vec3<f32>,              // c relative to the instance's origin
    position_increment: vec3<f32>,    // c − c_base
    joint: vec3<f32>,                 // J
}

struct Handle {
    displacement: vec3<f32>,  // φ_base
    increment: vec3<f32>,     // φ − φ_base
}

// The past of a bone, and that of a handle: what inertia takes from it (kernels/inertial_target.wgsl).
struct PastFrame {
    turn: mat3x3<f32>,        // A = Σ_k c_k (R(qⁿ⁻ᵏ) − R(qⁿ))
    first: mat3x3<f32>,       // R(qⁿ⁻¹)
    second: mat3x3<f32>,      // R(qⁿ⁻²)
    third: mat3x3<f32>,       // R(qⁿ⁻³)
    shift: vec3<f32>,         // b = Σ_k c_k (c(qⁿ⁻ᵏ) − c(qⁿ))
}

struct PastHandle {
    first: vec3<f32>,         // c₁ (φⁿ⁻¹ − φⁿ)
    second: vec3<f32>,        // c₂ (φⁿ⁻² − φⁿ)
    third: vec3<f32>,         // c₃ (φⁿ⁻³ − φⁿ)
}

struct Motion {
    displacement: vec3<f32>,  // d = x(q) − x(q_base)
    unposed: vec3<f32>,       // T
    blended: mat3x3<f32>,     // B = Σ_j w_j R_j
}
