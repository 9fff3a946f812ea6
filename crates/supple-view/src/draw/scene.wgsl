// A skin and solids under one sun that casts shadows. Everything is relative to what the camera looks at: positions of the
// skin are relative to its own origin, so that f32 resolves them anywhere in the world.

struct View {
    view_projection: mat4x4<f32>,
    sun_projection: mat4x4<f32>,
    eye: vec3<f32>,
    // How much of the skin's own colour the map of values leaves.
    own_colour: f32,
    sun: vec3<f32>,
    // Where the ground has faded into the background, m.
    horizon: f32,
    up: vec3<f32>,
    // Side of the ground's squares, m.
    square: f32,
    // To the skin's origin, and to the world's.
    skin_origin: vec3<f32>,
    world_origin: vec3<f32>,
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
    // How strong the normal map is; 0 where there is none.
    bumps: f32,
    // What shines by itself.
    glow: f32,
}

struct SkinFragment {
    @builtin(position) position: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) texture_coordinates: vec2<f32>,
    @location(2) place: vec3<f32>,
    @location(3) shown: vec4<f32>,
}

struct SolidVertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) x: vec4<f32>,
    @location(3) y: vec4<f32>,
    @location(4) z: vec4<f32>,
    @location(5) colour: vec4<f32>,
}

struct SolidFragment {
    @builtin(position) position: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) place: vec3<f32>,
    @location(2) colour: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var shadows: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(1) @binding(0) var<storage, read> skin: array<SkinVertex>;
// A colour for each vertex, and how much of it is shown.
@group(1) @binding(1) var<storage, read> shown: array<vec4<f32>>;
@group(2) @binding(0) var<storage, read> part: array<PartVertex>;
@group(2) @binding(1) var<uniform> surface: Surface;
@group(2) @binding(2) var base_colour: texture_2d<f32>;
@group(2) @binding(3) var bump: texture_2d<f32>;
@group(2) @binding(4) var repeating: sampler;

@vertex
fn skin_vertex(@builtin(vertex_index) index: u32) -> SkinFragment {
    let own = part[index];
    let posed = skin[own.skin_vertex];
    var out: SkinFragment;
    out.place = posed.position + view.skin_origin;
    out.position = view.view_projection * vec4(out.place, 1.0);
    out.normal = posed.normal;
    out.texture_coordinates = vec2(own.u, own.v);
    out.shown = shown[own.skin_vertex];
    return out;
}

@vertex
fn skin_shadow(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let place = skin[part[index].skin_vertex].position + view.skin_origin;
    return view.sun_projection * vec4(place, 1.0);
}

fn solid_place(in: SolidVertex) -> vec3<f32> {
    let p = vec4(in.position, 1.0);
    return vec3(dot(in.x, p), dot(in.y, p), dot(in.z, p));
}

@vertex
fn solid_vertex(in: SolidVertex) -> SolidFragment {
    var out: SolidFragment;
    out.place = solid_place(in);
    out.position = view.view_projection * vec4(out.place, 1.0);
    out.normal = vec3(dot(in.x.xyz, in.normal), dot(in.y.xyz, in.normal), dot(in.z.xyz, in.normal));
    out.colour = in.colour;
    return out;
}

@vertex
fn solid_shadow(in: SolidVertex) -> @builtin(position) vec4<f32> {
    return view.sun_projection * vec4(solid_place(in), 1.0);
}

// The share of the sun that reaches a place: nine looks into the depths that the sun sees.
fn sunlight(place: vec3<f32>, normal: vec3<f32>) -> f32 {
    let seen = view.sun_projection * vec4(place + 0.004 * normal, 1.0);
    let at = vec2(0.5 + 0.5 * seen.x, 0.5 - 0.5 * seen.y);
    let texel = 1.0 / vec2<f32>(textureDimensions(shadows));
    var light = 0.0;
    for (var i = -1; i <= 1; i++) {
        for (var j = -1; j <= 1; j++) {
            let off = texel * vec2(f32(i), f32(j));
            light += textureSampleCompareLevel(shadows, shadow_sampler, at + off, seen.z - 0.002);
        }
    }
    let outside = any(at < vec2(0.0)) || any(at > vec2(1.0));
    return select(light / 9.0, 1.0, outside);
}

fn lit(colour: vec3<f32>, place: vec3<f32>, normal: vec3<f32>, shine: f32) -> vec3<f32> {
    let facing = dot(normal, view.sun);
    let sun = max(facing, 0.0) * sunlight(place, normal);
    let sky = 0.5 + 0.5 * dot(normal, view.up);
    let half_way = normalize(view.sun + normalize(view.eye - place));
    let gleam = shine * pow(max(dot(normal, half_way), 0.0), 40.0) * sun;
    return colour * (0.68 * sun + 0.12 + 0.2 * sky) + vec3(gleam);
}

// The normal map's normal, in the tangent frame of the drawn triangle, which derivatives give.
fn bumped(in: SkinFragment, normal: vec3<f32>) -> vec3<f32> {
    let a = dpdx(in.place);
    let b = dpdy(in.place);
    let s = dpdx(in.texture_coordinates);
    let t = dpdy(in.texture_coordinates);
    let texel = 2.0 * textureSample(bump, repeating, in.texture_coordinates).xyz - 1.0;
    let side = s.x * t.y - s.y * t.x;
    let along = sign(side) * (a * t.y - b * s.y);
    let flat = along - normal * dot(normal, along);
    if (surface.bumps == 0.0 || dot(flat, flat) < 1e-24) {
        return normal;
    }
    let tangent = normalize(flat);
    let bitangent = cross(normal, tangent);
    return normalize(surface.bumps * (texel.x * tangent - texel.y * bitangent) + texel.z * normal);
}

@fragment
fn skin_colour(in: SkinFragment) -> @location(0) vec4<f32> {
    let texel = surface.colour * textureSample(base_colour, repeating, in.texture_coordinates);
    // A vertex of no triangle of the skin's has no normal: then the facet's.
    let facet = normalize(cross(dpdy(in.place), dpdx(in.place)));
    let length = length(in.normal);
    let smooth_normal = select(facet, in.normal / length, length > 0.1);
    let normal = bumped(in, smooth_normal);
    if (texel.a < surface.cutoff) {
        discard;
    }
    let base = mix(texel.rgb, in.shown.rgb, in.shown.a * (1.0 - view.own_colour));
    return vec4(lit(base, in.place, normal, 0.07) + surface.glow * base, 1.0);
}

const BACKGROUND = vec3<f32>(0.55, 0.6, 0.66);

@fragment
fn solid_colour(in: SolidFragment) -> @location(0) vec4<f32> {
    let normal = normalize(in.normal);
    if (in.colour.a > 0.0) {
        return vec4(lit(in.colour.rgb, in.place, normal, 0.25), 1.0);
    }
    // The ground: squares across whichever axis points up, which blur where they are smaller than a pixel.
    let from_origin = in.place - view.world_origin;
    let first = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), view.up.x > 0.5);
    let second = cross(view.up, first);
    let at = vec2(dot(from_origin, first), dot(from_origin, second)) / view.square;
    let blur = max(fwidth(at.x), fwidth(at.y));
    let square = floor(at);
    let dark = mix(abs(square.x + square.y) % 2.0, 0.5, smoothstep(0.1, 0.6, blur));
    let away = smoothstep(0.25 * view.horizon, view.horizon, length(in.place));
    return vec4(mix(lit(in.colour.rgb * (1.0 - 0.14 * dark), in.place, normal, 0.0), BACKGROUND, away), 1.0);
}

// What is seen through everything: arrows and dots.
@fragment
fn overlay_colour(in: SolidFragment) -> @location(0) vec4<f32> {
    let facing = 0.7 + 0.3 * abs(dot(normalize(in.normal), normalize(view.eye - in.place)));
    return vec4(in.colour.rgb * facing, 1.0);
}
