// What a surface emits towards an eye: glTF 2.0 metallic-roughness (appendix B) under
// punctual lights and the analytic environment that src/scene/mod.rs defines. All in the
// pinhole's view space (right, up, backwards; metres). Whoever imports this binds the
// lights and adds `from_light` of each to `from_environment` and what is emitted.

const PI = 3.14159265;

struct Environment {
    /// World axes in view space.
    view_from_world_x: vec4f,
    view_from_world_y: vec4f,
    view_from_world_z: vec4f,
    zenith: vec4f,
    horizon: vec4f,
    ground: vec4f,
    softbox: f32,
    light_count: u32,
}

struct Light {
    position: vec3f,
    /// Reciprocal of the range; 0 for none.
    inverse_range: f32,
    direction: vec3f,
    /// 0 directional, 1 point, 2 spot.
    kind: u32,
    intensity: vec3f,
    cos_inner: f32,
    cos_outer: f32,
}

/// A point of a surface that takes part in the light.
struct SurfacePoint {
    position: vec3f,
    normal: vec3f,
    base_color: vec3f,
    metallic: f32,
    roughness: f32,
    emitted: vec3f,
}

fn unit(v: vec3f, otherwise: vec3f) -> vec3f {
    let length2 = dot(v, v);
    return select(otherwise, v * inverseSqrt(max(length2, 1e-30)), length2 > 1e-30);
}

// ---- the environment (see Environment in src/scene/mod.rs) ----

fn height(environment: Environment, direction: vec3f) -> f32 {
    return dot(direction, environment.view_from_world_y.xyz);
}

fn environment_radiance(environment: Environment, direction: vec3f) -> vec3f {
    let y = height(environment, direction);
    if y >= 0.0 {
        return mix(environment.horizon.rgb, environment.zenith.rgb, y);
    }
    return mix(environment.horizon.rgb, environment.ground.rgb, min(-3.0 * y, 1.0));
}

fn ambient(environment: Environment, normal: vec3f) -> vec3f {
    let low = 0.5 * (environment.ground.rgb + environment.horizon.rgb);
    let high = 0.5 * (environment.zenith.rgb + environment.horizon.rgb);
    return mix(low, high, 0.5 * (height(environment, normal) + 1.0));
}

fn reflected(environment: Environment, direction: vec3f, roughness: f32) -> vec3f {
    let base = mix(environment_radiance(environment, direction), ambient(environment, direction), roughness);
    let width = 0.02 + 0.3 * roughness;
    var boxes = 0.0;
    if environment.softbox == 0.0 {
        return base;
    }
    for (var i = 0u; i < 4u; i++) {
        let sx = select(-1.0, 1.0, (i & 1u) != 0u);
        let sz = select(-0.6, 0.6, (i & 2u) != 0u);
        let world = normalize(vec3f(sx, 1.2, sz));
        let axis = environment.view_from_world_x.xyz * world.x + environment.view_from_world_y.xyz * world.y + environment.view_from_world_z.xyz * world.z;
        boxes += smoothstep(0.9 - width, 0.9 + width, dot(direction, axis));
    }
    return base + environment.softbox * boxes;
}

/// Split-sum environment BRDF, analytic fit (Karis, "Physically Based Shading on Mobile", 2014).
fn environment_brdf(f0: vec3f, roughness: f32, n_dot_v: f32) -> vec3f {
    let r = roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a004 = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    let ab = vec2f(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// ---- punctual lights (KHR_lights_punctual) ----

struct Incident {
    to_light: vec3f,
    radiance: vec3f,
}

fn incident(light: Light, position: vec3f) -> Incident {
    if light.kind == 0u {
        return Incident(-light.direction, light.intensity);
    }
    let offset = light.position - position;
    let distance2 = max(dot(offset, offset), 1e-8);
    let to_light = offset * inverseSqrt(distance2);
    let relative2 = distance2 * light.inverse_range * light.inverse_range;
    var falloff = clamp(1.0 - relative2 * relative2, 0.0, 1.0) / distance2;
    if light.kind == 2u {
        let cosine = dot(-to_light, light.direction);
        let cone = clamp((cosine - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4), 0.0, 1.0);
        falloff *= cone * cone;
    }
    return Incident(to_light, light.intensity * falloff);
}

/// A surface point as one eye sees it.
struct Facing {
    to_eye: vec3f,
    n_dot_v: f32,
    f0: vec3f,
    diffuse_albedo: vec3f,
}

fn facing(point: SurfacePoint, eye: vec3f) -> Facing {
    let to_eye = unit(eye - point.position, point.normal);
    let n_dot_v = clamp(dot(point.normal, to_eye), 1e-4, 1.0);
    let f0 = mix(vec3f(0.04), point.base_color, point.metallic);
    return Facing(to_eye, n_dot_v, f0, point.base_color * (1.0 - point.metallic));
}

/// Radiance towards the eye from a light.
fn from_light(light: Light, point: SurfacePoint, seen: Facing) -> vec3f {
    let light_here = incident(light, point.position);
    let n_dot_l = dot(point.normal, light_here.to_light);
    if n_dot_l <= 0.0 {
        return vec3f(0.0);
    }
    // Below this the highlight of a punctual light is smaller than a pixel can hold.
    let alpha = pow(max(point.roughness, 0.045), 2.0);
    let alpha2 = alpha * alpha;
    let halfway = unit(seen.to_eye + light_here.to_light, point.normal);
    let n_dot_h = clamp(dot(point.normal, halfway), 0.0, 1.0);
    let v_dot_h = clamp(dot(seen.to_eye, halfway), 0.0, 1.0);
    let d_root = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
    let distribution = alpha2 / (PI * d_root * d_root);
    let smith_v = n_dot_l * sqrt(seen.n_dot_v * seen.n_dot_v * (1.0 - alpha2) + alpha2);
    let smith_l = seen.n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - alpha2) + alpha2);
    let visibility = 0.5 / max(smith_v + smith_l, 1e-6);
    let fresnel = seen.f0 + (1.0 - seen.f0) * pow(1.0 - v_dot_h, 5.0);
    let brdf = (1.0 - fresnel) * seen.diffuse_albedo / PI + fresnel * (distribution * visibility);
    return brdf * light_here.radiance * n_dot_l;
}

/// Radiance towards the eye from the environment.
fn from_environment(environment: Environment, point: SurfacePoint, seen: Facing) -> vec3f {
    let mirror = reflect(-seen.to_eye, point.normal);
    return seen.diffuse_albedo * ambient(environment, point.normal)
        + environment_brdf(seen.f0, point.roughness, seen.n_dot_v) * reflected(environment, mirror, point.roughness);
}
