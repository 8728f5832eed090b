/* SPDX-License-Identifier: MIT */
/* Models as tables of pieces. */
#include "tests/glb_build.h"
#include "tests/stand_in.h"

#include <unistd.h>

enum { RIGHT = 1, LEFT = 2, TOP = 4, BOTTOM = 8, FRONT = 16, BACK = 32, BOX = 63 };

struct piece {
    const char *name; /* of its mesh and node. Pieces of one name, which follow each other, are primitives of one mesh */
    uint32_t faces;   /* of a box; 0: a ball of rings and segments */
    vec3 place, size; /* middle and extent */
    uint32_t rings, segments;
    float waves; /* depth of the ball's waves, a part of its radius */
    uint32_t material;
    uint32_t columns, rows; /* copies to the right and above, each with a material of its own; 0: none */
    float step;             /* from copy to copy */
    const char *node, *primitive;
    uint32_t mode; /* of glTF; 0: triangles */
};

struct texture {
    enum stand_in_texture kind;
    uint32_t side;
};

/** JSON with ' for ". In materials, @ and # are the column and the row, scaled to 0 .. 1. Lists end with zeros. */
struct model {
    const char *name;
    const struct piece *pieces;
    const char *const *materials;
    const struct texture *textures;
    const char *root, *nodes; /* more members of the root; nodes before those of the pieces */
    uint32_t node_count;
    const char *node_roots; /* those of `nodes` that are in the scene */
    bool tangents, second_uv;
};

#define BASE(n) "'pbrMetallicRoughness':{'baseColorTexture':{'index':" #n "}"
#define MAPS(normal, surface, color) \
    BASE(color) ",'metallicRoughnessTexture':{'index':" #surface "}},'occlusionTexture':{'index':" #surface "},'normalTexture':{'index':" #normal "}"
#define FACTORS(color, metallic, roughness) "'pbrMetallicRoughness':{'baseColorFactor':[" color ",1],'metallicFactor':" #metallic ",'roughnessFactor':" #roughness "}"
#define PIECES(...) .pieces = (const struct piece[]){__VA_ARGS__, {0}}
#define MATERIALS(...) .materials = (const char *const[]){__VA_ARGS__, NULL}
#define TEXTURES(...) .textures = (const struct texture[]){__VA_ARGS__, {0}}
#define USED(extensions) "'extensionsUsed':[" extensions "]"
#define TRANSFORM(n) "'index':" #n ",'extensions':{'KHR_texture_transform':{'offset':[-0.5,0.5],'rotation':0.1,'scale':[3,3]}}"
#define SHEEN(color, base, metallic) \
    "'pbrMetallicRoughness':{'baseColorFactor':[" base ",1],'baseColorTexture':{" TRANSFORM(2) "},'metallicFactor':" #metallic ",'roughnessFactor':0.8},'normalTexture':{'scale':0.6," TRANSFORM(0) "}," \
    "'occlusionTexture':{'index':1,'texCoord':1},'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[" color "],'sheenRoughnessFactor':0.5}}"
#define WOOD(base, surface) \
    "'pbrMetallicRoughness':{'baseColorFactor':[" base ",1],'baseColorTexture':{" TRANSFORM(3) "},'metallicRoughnessTexture':{" TRANSFORM(surface) "}},'occlusionTexture':{'index':1,'texCoord':1}"
#define VARIANT(other) ",'extensions':{'KHR_materials_variants':{'mappings':[{'material':" #other ",'variants':[1]}]}}"
#define COAT(more) "'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':1" more "}}"
#define FILM(more) "'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':1," more "}}"
#define NORMAL_MAP(n) "'normalTexture':{'index':" #n "}"

static const struct model models[] = {
    {"FlightHelmet/FlightHelmet.gltf", /* a head with a cap, a hose, metal parts, goggles, and lenses that are blended */
     PIECES({"hose", 0, {0.06f, 0.22f, 0.08f}, {0.08f, 0.3f, 0.08f}, 40, 16, 0.15f, .material = 0}, {"stand", BOX, {0, 0.04f, 0}, {0.3f, 0.08f, 0.3f}, .material = 1},
            {"stand", 0, {0, 0.3f, 0}, {0.2f, 0.5f, 0.22f}, 24, 24, 0.1f, .material = 1}, {"goggles", 0, {0, 0.54f, 0.06f}, {0.26f, 0.12f, 0.16f}, 16, 24, 0.05f, .material = 2},
            {"metal", 0, {-0.13f, 0.45f, 0}, {0.05f, 0.2f, 0.12f}, 16, 16, 0.1f, .material = 3}, {"metal", 0, {0.13f, 0.45f, 0}, {0.05f, 0.2f, 0.12f}, 16, 16, 0.1f, .material = 3},
            {"cap", 0, {0, 0.52f, -0.02f}, {0.25f, 0.36f, 0.27f}, 32, 32, 0.02f, .material = 4}, {"lenses", 0, {0, 0.55f, 0.13f}, {0.2f, 0.08f, 0.06f}, 12, 24, 0, .material = 5}),
     MATERIALS(MAPS(0, 1, 2) ",'doubleSided':true", MAPS(0, 1, 2), MAPS(3, 4, 5), MAPS(6, 7, 8), MAPS(9, 10, 11), MAPS(12, 13, 14) ",'alphaMode':'BLEND'"),
     TEXTURES({STAND_IN_NORMAL, 128}, {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 256}, {STAND_IN_NORMAL, 128}, {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 256}, {STAND_IN_NORMAL, 128},
              {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 128}, {STAND_IN_NORMAL, 128}, {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 256}, {STAND_IN_NORMAL, 32}, {STAND_IN_SURFACE, 128},
              {STAND_IN_CLEAR, 128}),
     .tangents = true},
    {"DamagedHelmet.glb", PIECES({"helmet", 0, {0, 0, 0}, {1.9f, 1.8f, 2}, 60, 64, 0.12f, .material = 0, .node = ",'rotation':[0.7071068,0,0,0.7071068]"}),
     MATERIALS(MAPS(4, 1, 0) ",'emissiveFactor':[1,1,1],'emissiveTexture':{'index':2}"),
     TEXTURES({STAND_IN_COLOR, 256}, {STAND_IN_SURFACE, 256}, {STAND_IN_GLOW, 256}, {STAND_IN_COLOR, 32}, {STAND_IN_NORMAL, 256})},
    {"CornellBox.glb", /* a room without a front; the lamp glows and is no light */
     PIECES({"lamp", BOTTOM, {-278, 547.9f, -279.5f}, {130, 0, 105}, .material = 0}, {"large", BOX, {-368, 165, -351}, {160, 330, 160}, .material = 1},
            {"small", BOX, {-185, 82.5f, -169}, {160, 165, 160}, .material = 1}, {"room", TOP | BOTTOM | BACK, {-276.8f, 274.4f, -279.6f}, {556, 548.8f, 559.2f}, .material = 2},
            {"room", LEFT, {-276.8f, 274.4f, -279.6f}, {556, 548.8f, 559.2f}, .material = 3}, {"room", RIGHT, {-276.8f, 274.4f, -279.6f}, {556, 548.8f, 559.2f}, .material = 4}),
     MATERIALS(FACTORS("0.8,0.8,0.8", 0, 0.5) ",'doubleSided':true,'emissiveFactor':[1,1,1],'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':100}}",
               FACTORS("0.5,0.5,0.5", 0, 0.5) ",'doubleSided':true", FACTORS("0.4,0.4,0.4", 0, 0.5) ",'doubleSided':true", FACTORS("0.5,0,0", 0, 0.5) ",'doubleSided':true",
               FACTORS("0,0.5,0", 0, 0.5) ",'doubleSided':true"),
     .root = USED("'KHR_materials_emissive_strength'")},
    {"gltf_primitives.glb", /* a cube, each side in another mode */
     PIECES({"cube", TOP, {0, 0, 0}, {2, 2, 2}, .material = 0, .mode = 5}, {"cube", FRONT, {0, 0, 0}, {2, 2, 2}, .material = 1, .mode = 6},
            {"cube", BACK, {0, 0, 0}, {2, 2, 2}, .material = 2, .mode = 4}, {"cube", RIGHT | LEFT | BOTTOM, {0, 0, 0}, {2, 2, 2}, .material = 3}),
     MATERIALS(FACTORS("0.8,0.12,0.12", 0, 0.5), FACTORS("0.2,0.8,0.02", 0, 0.5), FACTORS("0.02,0.1,0.8", 0, 0.5), FACTORS("0.8,0.8,0.8", 0, 0.5))},
    {"Lights.glb", PIECES({"cube", BOX, {0, 0, 0}, {2, 2, 2}, .material = 0}), MATERIALS(FACTORS("0.8,0.8,0.8", 0, 0.5)),
     .root = USED("'KHR_lights_punctual'") ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':5,'color':[1,0,0]},"
                                           "{'type':'spot','intensity':10,'spot':{'outerConeAngle':0.392699}},{'type':'spot','intensity':3,'spot':{'innerConeAngle':0.1}},"
                                           "{'type':'directional'}]}}",
     .nodes = "{'children':[1],'rotation':[0.1690758,0.7558803,-0.2721714,0.5709475],'translation':[2.598804,3.568508,-1.005454]},"
              "{'rotation':[-0.7071068,0,0,0.7071068],'extensions':{'KHR_lights_punctual':{'light':0}}},"
              "{'rotation':[-0.7071068,0,0,0.7071068],'scale':[1,1,3],'extensions':{'KHR_lights_punctual':{'light':1}}},"
              "{'translation':[0,6,0],'extensions':{'KHR_lights_punctual':{'light':2}}},{'extensions':{'KHR_lights_punctual':{'light':3}}},",
     .node_count = 5, .node_roots = "0,2,3,4,"},
    {"geometry-camera-light.glb", PIECES({"cube", BOX, {0, 0, 0}, {2, 2, 2}, .material = 0}), MATERIALS(FACTORS("0.8,0.8,0.8", 0, 0.4)),
     .root = "'cameras':[{'type':'perspective','perspective':{'yfov':0.4,'znear':0.1,'zfar':100}},{'type':'orthographic','orthographic':{'xmag':24,'ymag':13.5,'znear':0.1,'zfar':100}}]",
     .nodes = "{'name':'near','camera':0,'translation':[0,0,8]},{'name':'above','camera':1,'rotation':[-0.7071068,0,0,0.7071068],'translation':[0,20,0]},", .node_count = 2, .node_roots = "0,1,"},
    {"materials/ClearCoatTest.glb", /* a coat over paint: plain, by a texture, of textured roughness, over bumps, with bumps of its own */
     PIECES({"plain", 0, {-4, 1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 0}, {"coated", 0, {-2, 1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 1},
            {"in part", 0, {0, 1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 2}, {"rough", 0, {2, 1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 3},
            {"over bumps", 0, {-3, -1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 4}, {"bumps", 0, {-1, -1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 5},
            {"both", 0, {1, -1, 0}, {1.8f, 1.8f, 1.8f}, 20, 28, 0, .material = 6}, {"wall", FRONT, {-1, 0, -1.5f}, {9, 5, 0}, .material = 7}),
     MATERIALS(FACTORS("0.5,0.02,0.01", 0, 0.44), FACTORS("0.5,0.02,0.01", 0, 0.44) "," COAT(",'clearcoatRoughnessFactor':0.03"),
               FACTORS("0.01,0.02,0.1", 0, 0.44) "," COAT(",'clearcoatRoughnessFactor':0.03,'clearcoatTexture':{'index':0}"),
               FACTORS("0.01,0.02,0.1", 0, 0.6) "," COAT(",'clearcoatRoughnessFactor':1,'clearcoatRoughnessTexture':{'index':0}"),
               FACTORS("0.01,0.02,0.1", 0, 0.44) "," NORMAL_MAP(1) "," COAT(",'clearcoatRoughnessFactor':0.03"),
               FACTORS("0.01,0.02,0.1", 0, 0.44) "," COAT(",'clearcoatRoughnessFactor':0.1,'clearcoatNormalTexture':{'index':1}"),
               FACTORS("0.01,0.02,0.1", 0, 0.44) "," NORMAL_MAP(1) "," COAT(",'clearcoatRoughnessFactor':0.1,'clearcoatNormalTexture':{'index':1}"), BASE(2) ",'metallicFactor':0}"),
     TEXTURES({STAND_IN_SURFACE, 64}, {STAND_IN_NORMAL, 64}, {STAND_IN_COLOR, 64}), .root = USED("'KHR_materials_clearcoat'")},
    {"materials/IridescenceSuzanne.glb", /* films on paint, on metal, of textured thickness */
     PIECES({"paint", 0, {-3, 0, 0}, {2.4f, 2, 2}, 24, 36, 0.1f, .material = 0}, {"metal", 0, {0, 0, 0}, {2.4f, 2, 2}, 24, 36, 0.1f, .material = 1}, {"glass", 0, {3, 0, 0}, {2.4f, 2, 2}, 24, 36, 0.1f, .material = 2}),
     MATERIALS(FACTORS("0.4,0.4,0.4", 0, 0.1) "," FILM("'iridescenceIor':1.33"), FACTORS("0.4,0.4,0.4", 1, 0.1) "," FILM("'iridescenceIor':1.33,'iridescenceThicknessMaximum':400"),
               FACTORS("1,1,1", 0, 0.1) ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':1,'iridescenceIor':1.8,'iridescenceThicknessMaximum':600,"
                                        "'iridescenceThicknessMinimum':200,'iridescenceThicknessTexture':{'index':0}},'KHR_materials_transmission':{'transmissionFactor':1},"
                                        "'KHR_materials_volume':{'thicknessFactor':2}}"),
     TEXTURES({STAND_IN_SURFACE, 64}),
     .root = USED("'KHR_materials_iridescence','KHR_materials_transmission','KHR_materials_volume','KHR_lights_punctual'") ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':500}]}}",
     .nodes = "{'translation':[5,5,5],'extensions':{'KHR_lights_punctual':{'light':0}}},", .node_count = 1, .node_roots = "0,"},
    {"materials/AnisotropyStrengthTest.glb", /* strength grows to the right, roughness upward; the last has textured directions */
     PIECES({"ball", 0, {0, 0, 0}, {0.9f, 0.9f, 0.9f}, 12, 16, 0, .material = 0, .columns = 7, .rows = 7, .step = 1}, {"brushed", 0, {7.2f, 3, 0}, {1.2f, 3, 1.2f}, 16, 24, 0, .material = 1}),
     MATERIALS("'pbrMetallicRoughness':{'roughnessFactor':#},'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':@}}",
               "'pbrMetallicRoughness':{'roughnessFactor':0.4},'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':1,'anisotropyRotation':0.5,'anisotropyTexture':{'index':0}}}"),
     TEXTURES({STAND_IN_DIRECTIONS, 64}), .root = USED("'KHR_materials_anisotropy'"), .tangents = true},
    {"materials/AlphaBlendModeTest.glb", /* the same picture in each mode, and three cutoffs, above a bed */
     PIECES({"opaque", FRONT, {-3, 1.03f, 0}, {1.1f, 1.87f, 0}, .material = 5}, {"blend", FRONT, {-1.5f, 1.03f, 0}, {1.1f, 1.87f, 0}, .material = 1},
            {"cutoff 25", FRONT, {0, 1.03f, 0}, {1.1f, 1.87f, 0}, .material = 2}, {"cutoff", FRONT, {1.5f, 1.03f, 0}, {1.1f, 1.87f, 0}, .material = 4},
            {"cutoff 75", FRONT, {3, 1.03f, 0}, {1.1f, 1.87f, 0}, .material = 3}, {"bed", BOX, {0, 0, -0.1f}, {8.6f, 0.2f, 1.3f}, .material = 0},
            {"bed", FRONT, {0, 1.1f, -0.75f}, {8.6f, 2.4f, 0}, .material = 0}, {"leaves", RIGHT | FRONT | TOP, {0.5f, 0.3f, 0.35f}, {0.4f, 0.4f, 0.4f}, .material = 4}),
     MATERIALS(MAPS(0, 1, 2), BASE(3) ",'metallicFactor':0,'roughnessFactor':0.8},'doubleSided':true,'alphaMode':'BLEND'",
               BASE(3) ",'metallicFactor':0,'roughnessFactor':0.8},'doubleSided':true,'alphaMode':'MASK','alphaCutoff':0.25",
               BASE(3) ",'metallicFactor':0,'roughnessFactor':0.8},'doubleSided':true,'alphaMode':'MASK','alphaCutoff':0.75",
               BASE(3) ",'metallicFactor':0,'roughnessFactor':0.8},'doubleSided':true,'alphaMode':'MASK'", BASE(3) ",'metallicFactor':0,'roughnessFactor':0.8},'doubleSided':true"),
     TEXTURES({STAND_IN_NORMAL, 128}, {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 128}, {STAND_IN_HOLES, 128}), .tangents = true},
    {"materials/ClearCoatCarPaint.glb", PIECES({"ball", 0, {0, 0.5f, 0}, {1, 1, 1}, 32, 48, 0, .material = 0}),
     MATERIALS(FACTORS("0.7,0,0", 0.3, 0.4) ",'normalTexture':{'index':0,'scale':0.2,'extensions':{'KHR_texture_transform':{'scale':[3,3]}}},"
                                            "'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':1,'clearcoatRoughnessFactor':0}}"),
     TEXTURES({STAND_IN_NORMAL, 128}), .root = USED("'KHR_texture_transform','KHR_materials_clearcoat'")},
    {"materials/MetalRoughSpheresNoTextures.glb", /* roughness grows to the right, metalness upward, in gray and in yellow */
     PIECES({"gray", 0, {0, 0, 0}, {0.9f, 0.9f, 0.9f}, 12, 16, 0, .material = 0, .columns = 7, .rows = 7, .step = 1}, {"yellow", 0, {8, 0, 0}, {0.9f, 0.9f, 0.9f}, 12, 16, 0, .material = 1, .columns = 7, .rows = 7, .step = 1}),
     MATERIALS(FACTORS("0.6,0.6,0.6", #, @) ",'doubleSided':true", FACTORS("0.7,0.55,0.05", #, @) ",'doubleSided':true")},
    {"materials/SheenChair/SheenChair.gltf", /* fabric, wood, metal and a label, in two variants */
     PIECES({"fabric", BOX, {0, 0.36f, 0}, {0.8f, 0.14f, 0.5f}, .material = 0, .primitive = VARIANT(4)}, {"fabric", 0, {0, 0.56f, -0.22f}, {0.8f, 0.3f, 0.14f}, 16, 32, 0, .material = 0, .primitive = VARIANT(4)},
            {"wood", BOX, {-0.37f, 0.3f, 0}, {0.05f, 0.6f, 0.5f}, .material = 1, .primitive = VARIANT(5)}, {"wood", BOX, {0.37f, 0.3f, 0}, {0.05f, 0.6f, 0.5f}, .material = 1, .primitive = VARIANT(5)},
            {"metal", 0, {0, 0.25f, 0}, {0.6f, 0.05f, 0.4f}, 12, 24, 0, .material = 2}, {"label", FRONT, {0, 0.36f, 0.26f}, {0.27f, 0.05f, 0}, .material = 3}),
     MATERIALS(SHEEN("1,0.329,0.1", "0.883,0.035,0", 0), WOOD("0.14,0.07,0.01", 4), "'pbrMetallicRoughness':{'baseColorFactor':[0.28,0.26,0.23,1],'roughnessFactor':0.3},'occlusionTexture':{'index':1,'texCoord':1}",
               BASE(5) ",'metallicFactor':0},'occlusionTexture':{'index':1,'texCoord':1}", SHEEN("0.013,0.284,0.298", "0,0.094,0.099", 1), WOOD("0.036,0.036,0.036", 6)),
     TEXTURES({STAND_IN_NORMAL, 128}, {STAND_IN_SURFACE, 128}, {STAND_IN_COLOR, 128}, {STAND_IN_COLOR, 128}, {STAND_IN_SURFACE, 64}, {STAND_IN_COLOR, 64}, {STAND_IN_SURFACE, 64}),
     .root = USED("'KHR_texture_transform','KHR_materials_sheen','KHR_materials_variants'") ",'extensions':{'KHR_materials_variants':{'variants':[{'name':'red'},{'name':'blue'}]}}", .second_uv = true},
};

/* ---- shapes ---- */

/** A point of a face; u to the right and v downward, seen from outside, 0 .. 1. */
static vec3 point_at(const struct piece *p, uint32_t face, float u, float v) {
    float at[3];
    if (p->faces) {
        const uint32_t axis = face / 2;
        const float side = face % 2 ? -1 : 1, right = 2 * u - 1, up = 1 - 2 * v;
        at[axis] = side;
        at[(axis + 1) % 3] = right;
        at[(axis + 2) % 3] = side * up;
    } else {
        const float wide = sinf(PI * v) * (1 + p->waves * sinf(6 * PI * v) * (1 + 0.3f * cosf(6 * PI * u)));
        at[0] = wide * cosf(-2 * PI * u), at[1] = cosf(PI * v), at[2] = wide * sinf(-2 * PI * u);
    }
    return vec3_add(p->place, vec3_make(at[0] * p->size.x / 2, at[1] * p->size.y / 2, at[2] * p->size.z / 2));
}

static vec3 slope(const struct piece *p, uint32_t face, float u, float v, bool down) {
    const float step = 1.0f / 256, low = down ? fmaxf(0, v - step) : u - step, high = down ? fminf(1, v + step) : u + step;
    return vec3_sub(point_at(p, face, down ? u : high, down ? high : v), point_at(p, face, down ? u : low, down ? low : v));
}

struct shape {
    vec3 *positions, *normals;
    vec4 *tangents;
    vec2 *uv;
    uint16_t *indices;
    uint32_t vertices, corners;
    struct box bounds;
};

static void add_face(struct shape *s, const struct piece *p, uint32_t face) {
    const uint32_t across = p->faces ? 1 : p->segments, along = p->faces ? 1 : p->rings, first = s->vertices;
    for (uint32_t j = 0; j <= along; j++)
        for (uint32_t i = 0; i <= across; i++) {
            const float u = (float)i / (float)across, v = (float)j / (float)along;
            const float inner = p->faces ? v : fminf(0.99f, fmaxf(0.01f, v)); /* at the poles all of a ring is one point */
            const vec3 right = vec3_normalize(slope(p, face, u, inner, false)), n = vec3_normalize(vec3_cross(slope(p, face, u, inner, true), right));
            const bool pole = !p->faces && (j == 0 || j == along);
            const uint32_t at = s->vertices++;
            s->positions[at] = point_at(p, face, i == across && !p->faces ? 0 : u, v);
            s->normals[at] = pole ? vec3_make(0, j == 0 ? 1 : -1, 0) : n;
            const vec3 t = vec3_normalize(vec3_add_scaled(right, s->normals[at], -vec3_dot(right, s->normals[at])));
            s->tangents[at] = (vec4){t.x, t.y, t.z, 1};
            s->uv[at] = (vec2){u, v};
            box_add_point(&s->bounds, s->positions[at]);
        }
    for (uint32_t j = 0; j < along; j++)
        for (uint32_t i = 0; i < across; i++) {
            const uint16_t a = (uint16_t)(first + j * (across + 1) + i), b = (uint16_t)(a + 1), c = (uint16_t)(a + across + 1), d = (uint16_t)(c + 1);
            const uint16_t strip[] = {a, c, b, d}, fan[] = {a, c, d, b}, low[] = {a, c, d}, high[] = {a, d, b};
            if (p->mode == 5 || p->mode == 6) {
                memcpy(s->indices, p->mode == 5 ? strip : fan, sizeof strip);
                s->corners = 4;
                continue;
            }
            if (p->faces || j + 1 < along) memcpy(s->indices + s->corners, low, sizeof low), s->corners += 3;
            if (p->faces || j > 0) memcpy(s->indices + s->corners, high, sizeof high), s->corners += 3;
        }
}

/* ---- files ---- */

/** Accessors of a piece: position, normal, texture coordinates, tangent, indices. */
enum { ACCESSORS = 5 };

static void add_shape(struct glb *g, struct glb_text *accessors, const struct piece *p) {
    const uint32_t room = p->faces ? 24 : (p->rings + 1) * (p->segments + 1), base = g->view_count;
    struct shape s = {calloc(room, sizeof(vec3)), calloc(room, sizeof(vec3)), calloc(room, sizeof(vec4)), calloc(room, sizeof(vec2)), calloc(room * 6, 2), .bounds = box_empty()};
    for (uint32_t face = 0; face < (p->faces ? 6 : 1); face++)
        if (!p->faces || p->faces >> face & 1) add_face(&s, p, face);
    glb_view(g, s.positions, s.vertices * sizeof *s.positions);
    glb_view(g, s.normals, s.vertices * sizeof *s.normals);
    glb_view(g, s.uv, s.vertices * sizeof *s.uv);
    glb_view(g, s.tangents, s.vertices * sizeof *s.tangents);
    glb_view(g, s.indices, s.corners * sizeof *s.indices);
    const vec3 low = s.bounds.low, high = s.bounds.high;
    glb_add(accessors, "%s{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u,\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]},", base ? "," : "", base, s.vertices,
            (double)low.x, (double)low.y, (double)low.z, (double)high.x, (double)high.y, (double)high.z);
    glb_add(accessors, "{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u},{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC2\",\"count\":%u},", base + 1, s.vertices, base + 2,
            s.vertices);
    glb_add(accessors, "{\"bufferView\":%u,\"componentType\":5126,\"type\":\"VEC4\",\"count\":%u},{\"bufferView\":%u,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":%u}", base + 3, s.vertices, base + 4,
            s.corners);
    free(s.positions), free(s.normals), free(s.tangents), free(s.uv), free(s.indices);
}

static void add_json(struct glb_text *t, const char *text, float column, float row) {
    for (; text && *text; text++) {
        if (*text == '@' || *text == '#') glb_add(t, "%g", (double)(*text == '@' ? column : row));
        else glb_add(t, "%c", *text == '\'' ? '"' : *text);
    }
}

static uint32_t copies_of(const struct piece *p) { return MAX(p->columns, 1) * MAX(p->rows, 1); }

static void add_primitive(struct glb_text *t, const struct model *m, uint32_t piece, uint32_t material) {
    const struct piece *p = &m->pieces[piece];
    const uint32_t a = ACCESSORS * piece;
    glb_add(t, "{\"material\":%u,\"indices\":%u,\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u,\"TEXCOORD_0\":%u", material, a + 4, a, a + 1, a + 2);
    if (m->tangents) glb_add(t, ",\"TANGENT\":%u", a + 3);
    if (m->second_uv) glb_add(t, ",\"TEXCOORD_1\":%u", a + 2);
    glb_add(t, "},\"mode\":%u", p->mode ? p->mode : 4);
    add_json(t, p->primitive, 0, 0);
    glb_add(t, "}");
}

static void add_pieces(struct glb *g, const struct model *m, uint32_t texture_view) {
    struct glb_text meshes = {0}, nodes = {0}, roots = {0}, materials = {0};
    uint32_t mesh_count = 0, material_count = 0;
    for (; m->materials[material_count]; material_count++) {
        glb_add(&materials, "%s{", material_count ? "," : "");
        add_json(&materials, m->materials[material_count], 0, 0);
        glb_add(&materials, "}");
    }
    add_json(&nodes, m->nodes, 0, 0);
    for (uint32_t i = 0; m->pieces[i].name; i++) {
        const struct piece *p = &m->pieces[i];
        const bool joins = i && strcmp(p->name, p[-1].name) == 0;
        for (uint32_t k = 0; k < copies_of(p); k++) {
            const uint32_t column = k % MAX(p->columns, 1), row = k / MAX(p->columns, 1);
            if (joins) glb_add(&meshes, ",");
            else glb_add(&meshes, "%s{\"name\":\"%s\",\"primitives\":[", mesh_count ? "," : "", p->name);
            if (k) {
                glb_add(&materials, ",{");
                add_json(&materials, m->materials[p->material], (float)column / (float)MAX(p->columns - 1, 1), (float)row / (float)MAX(p->rows - 1, 1));
                glb_add(&materials, "}");
            }
            add_primitive(&meshes, m, i, k ? material_count++ : p->material);
            if (p[1].name && strcmp(p->name, p[1].name) == 0) continue;
            glb_add(&meshes, "]}");
            glb_add(&nodes, "%s{\"name\":\"%s\",\"mesh\":%u,\"translation\":[%g,%g,0]", mesh_count ? "," : "", p->name, mesh_count, (double)(p->step * (float)column), (double)(p->step * (float)row));
            add_json(&nodes, p->node, 0, 0);
            glb_add(&nodes, "}");
            glb_add(&roots, "%s%u", mesh_count ? "," : "", m->node_count + mesh_count);
            mesh_count++;
        }
    }
    glb_add(&g->json, ",\"materials\":[%s],\"meshes\":[%s],\"nodes\":[%s],\"scene\":0,\"scenes\":[{\"nodes\":[%s%s]}]", materials.text, meshes.text, nodes.text, m->node_roots ? m->node_roots : "", roots.text);
    free(materials.text), free(meshes.text), free(nodes.text), free(roots.text);
    for (uint32_t i = 0; m->textures && m->textures[i].side; i++)
        glb_add(&g->json, "%s{\"bufferView\":%u,\"mimeType\":\"image/png\"}", i ? "," : ",\"images\":[", texture_view + i);
    for (uint32_t i = 0; m->textures && m->textures[i].side; i++) glb_add(&g->json, "%s{\"source\":%u}", i ? "," : "],\"textures\":[", i);
    if (m->textures) glb_add(&g->json, "]");
}

unsigned char *stand_in_model(const char *name, size_t *size) {
    const struct model *m = NULL;
    for (size_t i = 0; i < COUNT_OF(models); i++)
        if (strcmp(models[i].name, name) == 0) m = &models[i];
    if (!m) return stand_in_figure(name, size);
    struct glb g = {0};
    struct glb_text accessors = {0};
    for (uint32_t i = 0; m->pieces[i].name; i++) add_shape(&g, &accessors, &m->pieces[i]);
    const uint32_t texture_view = g.view_count;
    for (uint32_t i = 0; m->textures && m->textures[i].side; i++) {
        fnl_image picture = stand_in_picture(m->textures[i].kind, m->textures[i].side, 3 * i + 1);
        size_t png_size;
        unsigned char *png = stand_in_png(&picture, &png_size);
        glb_view(&g, png, png_size);
        free(png), free(picture.pixels);
    }
    glb_begin_json(&g);
    glb_add(&g.json, ",\"accessors\":[%s]", accessors.text);
    free(accessors.text);
    add_pieces(&g, m, texture_view);
    if (m->root) glb_add(&g.json, ",");
    add_json(&g.json, m->root, 0, 0);
    glb_add(&g.json, "}");
    return glb_finish(&g, size);
}

/* ---- samples ---- */

const char *stand_in_folder(void) {
    const char *folder = getenv("FANAL_SCENES");
    return folder ? folder : "../shared/scenes";
}

const char *stand_in_sample(const char *name) {
    static char path[1024];
    snprintf(path, sizeof path, "%s/%s", stand_in_folder(), name);
    return access(path, R_OK) == 0 ? path : NULL;
}
