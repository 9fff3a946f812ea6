// A skin and the ground. The skin is pulled: a part's own vertex says which vertex of the skin it is, of which the world
// keeps one where the file has several along a seam, so that nothing cracks and nothing is copied.

struct View {
    view_projection: mat4x4<f32>,
    previous_view_projection: mat4x4<f32>,
    // From what the camera looks at, now and a step before: to the skin's origin, and to the world's.
    skin: vec3<f32>,
    show_motion: f32,
    previous_skin: vec3<f32>,
    world: vec3<f32>,
    previous_world: vec3<f32>,
}

// As `World::skin_buffer` lays them out, 32 bytes each.
struct SkinVertex {
    position: vec3<f32>,
    normal: vec3<f32>,
}

// A vertex of a `RenderMesh`.
struct PartVertex {
    skin_vertex: u32,
    u: f32,
    v: f32,
}

struct Surface {
    colour: vec4<f32>,
    // Below this alpha nothing is drawn.
    cutoff: f32,
}

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) texture_coordinates: vec2<f32>,
    // In the world, m.
    @location(2) place: vec3<f32>,
    @location(3) now: vec4<f32>,
    @location(4) before: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(1) @binding(0) var<storage, read> skin: array<SkinVertex>;
@group(1) @binding(1) var<storage, read> previous_skin: array<SkinVertex>;
@group(2) @binding(0) var<storage, read> part: array<PartVertex>;
@group(2) @binding(1) var<uniform> surface: Surface;
@group(2) @binding(2) var base_colour: texture_2d<f32>;
@group(2) @binding(3) var repeating: sampler;

fn project(now: vec3<f32>, before: vec3<f32>) -> Fragment {
    var out: Fragment;
    out.now = view.view_projection * vec4(now, 1.0);
    out.before = view.previous_view_projection * vec4(before, 1.0);
    out.position = out.now;
    out.place = now - view.world;
    return out;
}

@vertex
fn skin_vertex(@builtin(vertex_index) index: u32) -> Fragment {
    let own = part[index];
    let posed = skin[own.skin_vertex];
    let before = previous_skin[own.skin_vertex].position + view.previous_skin;
    var out = project(posed.position + view.skin, before);
    out.normal = posed.normal;
    out.texture_coordinates = vec2(own.u, own.v);
    return out;
}

@vertex
fn ground_vertex(@builtin(vertex_index) index: u32) -> Fragment {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) - 0.5;
    // Under the camera wherever it goes, 20 m wide.
    let place = vec3(20.0 * corner.x - view.world.x, 0.0, 20.0 * corner.y - view.world.z);
    var out = project(place + view.world, place + view.previous_world);
    out.normal = vec3(0.0, 1.0, 0.0);
    return out;
}

fn lit(colour: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let sun = max(dot(normal, normalize(vec3(0.4, 0.8, 0.5))), 0.0);
    let sky = 0.5 + 0.5 * normal.y;
    return colour * (0.75 * sun + 0.35 * sky);
}

// What a texture of motion vectors would hold, 40 times as bright: half the picture's size is 1.
fn motion(in: Fragment) -> vec4<f32> {
    let way = in.now.xy / in.now.w - in.before.xy / in.before.w;
    return vec4(0.5 + 40.0 * way, 0.5, 1.0);
}

@fragment
fn skin_colour(in: Fragment) -> @location(0) vec4<f32> {
    let texel = surface.colour * textureSample(base_colour, repeating, in.texture_coordinates);
    // A vertex of no triangle of the skin's has no normal: then the facet's.
    let facet = normalize(cross(dpdy(in.place), dpdx(in.place)));
    if (texel.a < surface.cutoff) {
        discard;
    }
    if (view.show_motion > 0.5) {
        return motion(in);
    }
    let length = length(in.normal);
    return vec4(lit(texel.rgb, select(facet, in.normal / length, length > 0.1)), 1.0);
}

@fragment
fn ground_colour(in: Fragment) -> @location(0) vec4<f32> {
    if (view.show_motion > 0.5) {
        return motion(in);
    }
    let square = floor(in.place.xz / 0.5);
    let dark = abs(square.x + square.y) % 2.0;
    // It fades into the background.
    let away = smoothstep(2.0, 9.0, length(in.place.xz + view.world.xz));
    let colour = lit(vec3(0.42 - 0.06 * dark), in.normal);
    return vec4(mix(colour, BACKGROUND, away), 1.0);
}

const BACKGROUND = vec3<f32>(0.55, 0.6, 0.66);
