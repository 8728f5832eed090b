// SPDX-License-Identifier: MIT
// From interpolated attributes and a material to a surface. In fragment shaders textures use implicit gradients; with MATERIAL_GRADIENTS the
// attributes are variables that the shader fills, gradients too.
#ifndef MATERIAL_GLSL
#define MATERIAL_GLSL

#include "scene.glsl"
#include "surface.glsl"

#ifdef MATERIAL_GRADIENTS
vec3 in_position, in_normal;
vec3 in_geometric; // as surface.geometric
vec4 in_tangent, in_uv, in_color;
vec4 in_uv_dx, in_uv_dy; // of in_uv, per pixel to the right and down
uvec3 in_ids;
bool in_front_facing;
// Above 1 where the driver filters explicit gradients without anisotropy: at most so many samples along the longer one instead.
layout(constant_id = GRADIENT_TAPS_ID) const float GRADIENT_TAPS = 1.0;
// Variants for materials that need less: 0 where none has a texture, or a normal map.
layout(constant_id = HAS_TEXTURES_ID) const uint HAS_TEXTURES = 1u;
layout(constant_id = HAS_NORMAL_MAP_ID) const uint HAS_NORMAL_MAP = 1u;
#else
// Homogeneous: with several samples Mesa's CPU driver takes a varying at the centroid, but its perspective at the middle of the pixel. At edges in the middle
// of a slanted wall that moves a position by centimetres, into what is behind the surface. The fourth coordinate, 1 at all corners, is wrong by the
// same factor.
layout(location = 0) centroid in vec4 in_place;
#define in_position (in_place.xyz / in_place.w)
#define in_geometric (in_ids.z == 2u ? vec3(0.0) : geometric_of(dFdx(in_position), dFdy(in_position)))
layout(location = 1) centroid in vec3 in_normal;
layout(location = 2) centroid in vec4 in_tangent;
layout(location = 3) centroid in vec4 in_uv;
layout(location = 4) centroid in vec4 in_color;
layout(location = 5) flat in uvec3 in_ids; // material, item; 1: the instance mirrors, 2: not a triangle
#define in_front_facing gl_FrontFacing
const uint HAS_TEXTURES = 1u, HAS_NORMAL_MAP = 1u;
#endif

#define TEXTURE_BASE_COLOR 0
#define TEXTURE_METALLIC_ROUGHNESS 1
#define TEXTURE_NORMAL 2
#define TEXTURE_OCCLUSION 3
#define TEXTURE_EMISSIVE 4
#define TEXTURE_SPECULAR 5
#define TEXTURE_SPECULAR_COLOR 6

// Shaders that shade layers include lights/iterate.glsl first, and say LIGHTING_LAYERS.
#ifndef MATERIAL_LAYERS
#define MATERIAL_LAYERS false
#endif

// `offset` 1 for points, 0 for differences.
vec2 texture_uv(gpu_texture t, vec4 uvs, float offset) {
    vec2 uv = (t.flags & GPU_TEXTURE_UV1) == 0u ? uvs.xy : uvs.zw;
    return vec2(t.transform[0] * uv.x + t.transform[1] * uv.y + t.transform[2] * offset,
                t.transform[3] * uv.x + t.transform[4] * uv.y + t.transform[5] * offset);
}

#ifdef MATERIAL_TEXEL
vec4 material_texel(int slot); // with it the shader samples textures by itself
#endif

#ifndef MATERIAL_TEXEL
vec4 sample_texture(gpu_texture t) {
#ifdef MATERIAL_GRADIENTS
    vec2 uv = texture_uv(t, in_uv, 1.0), along = texture_uv(t, in_uv_dx, 0.0), across = texture_uv(t, in_uv_dy, 0.0);
    float taps = 1.0;
    if (GRADIENT_TAPS > 1.0 && (t.flags & GPU_TEXTURE_ROUND) == 0u) {
        vec2 size = vec2(textureSize(textures[nonuniformEXT(t.image)], 0));
        float a = length(along * size), b = length(across * size);
        taps = clamp(ceil(max(a, b) / max(min(a, b), 1e-6)), 1.0, GRADIENT_TAPS);
        vec2 longer = a > b ? along : across;
        across = a > b ? across : along;
        along = longer / taps;
    }
    vec4 sum = vec4(0.0);
    for (float i = 0.0; i < taps; i += 1.0) {
        vec2 at = uv + along * (i + 0.5 - 0.5 * taps);
        sum += textureGrad(sampler2D(textures[nonuniformEXT(t.image)], samplers[nonuniformEXT(t.sampler_index)]), at, along, across);
    }
    return sum / taps;
#else
    return texture(sampler2D(textures[nonuniformEXT(t.image)], samplers[nonuniformEXT(t.sampler_index)]), texture_uv(t, in_uv, 1.0));
#endif
}
#endif

// The texel, or white where the material has no such texture.
vec4 sample_slot(material_array materials, uint material, int slot) {
    if (HAS_TEXTURES == 0u) return vec4(1.0);
    gpu_texture t = materials.at[material].textures[slot];
    if (t.image == GPU_TEXTURE_NONE) return vec4(1.0);
#ifdef MATERIAL_TEXEL
    return material_texel(slot);
#else
    return sample_texture(t);
#endif
}

vec4 material_base_color(material_array materials, uint material) {
    return materials.at[material].base_color * in_color * sample_slot(materials, material, TEXTURE_BASE_COLOR);
}

// True where the cutout has a hole.
bool material_cut(material_array materials, uint material, float alpha) {
    return (materials.at[material].flags & GPU_MATERIAL_MASK) != 0u && alpha < materials.at[material].alpha_cutoff;
}

// Windings are told apart here, not by pipeline state, so that mirrored and plain instances can share a draw.
bool material_front_facing() { return in_front_facing != (in_ids.z == 1u); }

// True for the back of a single-sided surface, where the pipeline culls nothing.
bool material_culled(material_array materials, uint material) {
    return !material_front_facing() && (materials.at[material].flags & GPU_MATERIAL_DOUBLE_SIDED) == 0u;
}

// A texel of a normal map, from the axes of the surface to the world; `otherwise` where nothing is left of it.
vec3 bent_normal(vec3 mapped, vec4 turn, vec3 otherwise) {
    mapped.xy = vec2(dot(turn.xy, mapped.xy), dot(turn.zw, mapped.xy));
    vec3 bitangent = cross(in_normal, in_tangent.xyz) * in_tangent.w;
    vec3 bent = mapped.x * in_tangent.xyz + mapped.y * bitangent + mapped.z * in_normal;
    float bent2 = dot(bent, bent);
    return bent2 > 1e-20 && bent2 < 1e30 ? bent * inversesqrt(bent2) : otherwise;
}

#ifndef MATERIAL_TEXEL
vec4 sample_layer(layers_block from, int slot) {
    gpu_texture t = from.layers.textures[slot];
    return t.image == GPU_TEXTURE_NONE ? vec4(1.0) : sample_texture(t);
}

// True where more light goes through than not: shadow maps, which have nothing in between, have a hole there.
bool material_clear(material_array materials, uint material) {
    if ((materials.at[material].flags & GPU_MATERIAL_TRANSMISSIVE) == 0u) return false;
    layers_block from = materials.at[material].layers;
    float metallic = clamp(materials.at[material].metallic * sample_slot(materials, material, TEXTURE_METALLIC_ROUGHNESS).b, 0.0, 1.0);
    return from.layers.transmission * sample_layer(from, GPU_TEXTURE_TRANSMISSION).r * (1.0 - metallic) >= 0.5;
}

// `smooth_normal`: without any normal map, on the viewer's side as `normal` is, the material's.
surface_layers material_layers(layers_block from, vec3 smooth_normal, vec3 normal, bool turned) {
    surface_layers l;
#define PLAIN(member) l.member = from.layers.member;
#define TEXTURED(member, texture, channels) l.member = from.layers.member * sample_layer(from, texture).channels;
    LAYERS_PLAIN(PLAIN)
    LAYERS_TEXTURED(TEXTURED)
#ifdef TRANSMISSION
    LAYERS_TEXTURED_THROUGH(TEXTURED)
#endif
#undef PLAIN
#undef TEXTURED
    l.clearcoat_normal = smooth_normal;
    if (from.layers.textures[GPU_TEXTURE_CLEARCOAT_NORMAL].image != GPU_TEXTURE_NONE) {
        vec3 bent = bent_normal(sample_layer(from, GPU_TEXTURE_CLEARCOAT_NORMAL).xyz * 2.0 - 1.0, from.layers.clearcoat_normal_turn,
                                turned ? -smooth_normal : smooth_normal);
        l.clearcoat_normal = turned ? -bent : bent;
    }
    l.film_thickness = mix(from.layers.film_thinnest, from.layers.film_thickest, sample_layer(from, GPU_TEXTURE_IRIDESCENCE_THICKNESS).g);
    l.anisotropy = from.layers.anisotropy;
    vec4 turn = from.layers.anisotropy_turn;
    vec2 along = vec2(1.0, 0.0);
    if (from.layers.textures[GPU_TEXTURE_ANISOTROPY].image != GPU_TEXTURE_NONE) {
        vec3 texel = sample_layer(from, GPU_TEXTURE_ANISOTROPY).xyz;
        along = texel.xy * 2.0 - 1.0;
        l.anisotropy *= texel.z;
    }
    along = vec2(dot(turn.xy, along), dot(turn.zw, along));
    vec3 bitangent = cross(in_normal, in_tangent.xyz) * in_tangent.w, tangent = along.x * in_tangent.xyz + along.y * bitangent;
    tangent -= normal * dot(normal, tangent);
    float length2 = dot(tangent, tangent);
    if (length2 > 1e-20 && length2 < 1e30) l.tangent = tangent * inversesqrt(length2);
    else l.anisotropy = 0.0, l.tangent = vec3(0.0);
#ifdef TRANSMISSION
    l.absorption = from.layers.absorption;
    l.ior = from.layers.ior;
    l.dispersion = from.layers.dispersion;
#endif
    return l;
}
#endif

// Members are read where they are used: registers need not hold them while textures are sampled. `hole`: whether the cutout has one.
surface material_surface(material_array materials, uint material, out bool hole) {
    bool front_facing = material_front_facing();
    vec4 base = material_base_color(materials, material);
    hole = material_cut(materials, material, base.a);
    surface s;
    s.light_mask = LIGHT_MASK_ALL;
    s.position = in_position;
    s.geometric = in_geometric;
    s.alpha = (materials.at[material].flags & GPU_MATERIAL_BLEND) != 0u ? clamp(base.a, 0.0, 1.0) : 1.0;

    vec4 metallic_roughness = sample_slot(materials, material, TEXTURE_METALLIC_ROUGHNESS);
    s.metallic = clamp(materials.at[material].metallic * metallic_roughness.b, 0.0, 1.0);
    s.roughness = clamp(materials.at[material].roughness * metallic_roughness.g, 0.0, 1.0);
    float occlusion = metallic_roughness.r;
#ifndef MATERIAL_TEXEL // which keeps it in another place
    if ((materials.at[material].flags & GPU_MATERIAL_SHARED_OCCLUSION) == 0u)
#endif
        occlusion = sample_slot(materials, material, TEXTURE_OCCLUSION).r;
    s.occlusion = 1.0 + materials.at[material].occlusion_strength * (occlusion - 1.0);
    s.emissive = materials.at[material].emissive * sample_slot(materials, material, TEXTURE_EMISSIVE).rgb;
    s.dielectric_f90 = materials.at[material].specular * sample_slot(materials, material, TEXTURE_SPECULAR).a;
    vec3 specular_color = sample_slot(materials, material, TEXTURE_SPECULAR_COLOR).rgb;
    s.dielectric_f0 = min(materials.at[material].dielectric_f0 * specular_color, vec3(1.0)) * s.dielectric_f90;
    s.base_color = base.rgb;

    // A normal that vanished (a flattened instance, opposite neighbours) leaves something that is unit all the same.
    float length2 = dot(in_normal, in_normal);
    vec3 normal = length2 > 1e-30 && length2 < 1e30 ? in_normal * inversesqrt(length2) : vec3(0.0, 1.0, 0.0), smooth_normal = normal;
    if (HAS_NORMAL_MAP == 1u && materials.at[material].textures[TEXTURE_NORMAL].image != GPU_TEXTURE_NONE) {
        vec3 mapped = sample_slot(materials, material, TEXTURE_NORMAL).xyz * 2.0 - 1.0;
        normal = bent_normal(mapped, materials.at[material].normal_turn, normal);
    }
    bool turned = !front_facing && (materials.at[material].flags & GPU_MATERIAL_DOUBLE_SIDED) != 0u;
    s.normal = turned ? -normal : normal;

    if ((materials.at[material].flags & GPU_MATERIAL_UNLIT) != 0u) {
        s.emissive = s.base_color;
        s.base_color = vec3(0.0);
        s.metallic = 0.0;
        s.dielectric_f0 = vec3(0.0);
        s.dielectric_f90 = 0.0;
    }
    s.layered = false;
#ifndef MATERIAL_TEXEL // whose textures have no room for more
    if (MATERIAL_LAYERS && (materials.at[material].flags & GPU_MATERIAL_LAYERED) != 0u) {
        s.layered = true;
        layers_block layers = materials.at[material].layers;
        s.layers = material_layers(layers, turned ? -smooth_normal : smooth_normal, s.normal, turned);
    }
#endif
    return s;
}

surface material_surface(material_array materials, uint material) {
    bool hole;
    return material_surface(materials, material, hole);
}

#endif
