// Triangles of the interface. Colours are multiplied in sRGB, as the interface means them, and blended in light.

struct Screen {
    // Points.
    size: vec2<f32>,
}

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) texture_coordinates: vec2<f32>,
    @location(1) colour: vec4<f32>,
}

@group(0) @binding(0) var<uniform> screen: Screen;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var smooth_sampler: sampler;

@vertex
fn vertex(
    @location(0) place: vec2<f32>,
    @location(1) texture_coordinates: vec2<f32>,
    @location(2) colour: vec4<f32>,
) -> Fragment {
    var out: Fragment;
    let at = 2.0 * place / screen.size;
    out.position = vec4(at.x - 1.0, 1.0 - at.y, 0.0, 1.0);
    out.texture_coordinates = texture_coordinates;
    out.colour = colour;
    return out;
}

fn linear(srgb: vec3<f32>) -> vec3<f32> {
    let high = pow((srgb + vec3(0.055)) / vec3(1.055), vec3(2.4));
    return select(high, srgb / vec3(12.92), srgb < vec3(0.04045));
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let colour = in.colour * textureSample(image, smooth_sampler, in.texture_coordinates);
    return vec4(linear(colour.rgb), colour.a);
}
