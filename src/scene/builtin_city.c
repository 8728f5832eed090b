/* SPDX-License-Identifier: MIT */
/**
 * Night streets: blocks of houses around courtyards on a square grid, with shops, lamps, trees, cars and strings of lights.
 * The streets run along X and Z; the camera "street" looks down the one nearest to x = 0. EV100 3 suits it.
 */
#include "scene/builtin_city.h"

/** In the order in which lights are placed while there are any left. */
enum light_class {
    LIGHT_LAMP,
    LIGHT_CAR,
    LIGHT_SIGNAL,
    LIGHT_SHOP,
    LIGHT_SIGN,
    LIGHT_LANTERN,
    LIGHT_WASH,
    LIGHT_STRING,
    LIGHT_WINDOW,
    LIGHT_GARDEN
};

/** A light that may be placed; `angle` 0: a point light. */
struct candidate {
    enum light_class kind;
    uint32_t index;
    float distance; /* to the camera */
    vec3 position, direction, color;
    float intensity, range, angle;
};

struct city {
    struct builtin *b;
    struct city_meshes meshes;
    int blocks;   /* per side */
    float avenue; /* x of the street that the camera looks along */
    vec3 eye;
    ARRAY(struct candidate) candidates;
};

static float chance(struct city *c) { return random_float(&c->b->random); }
static uint32_t choose(struct city *c, uint32_t count) { return (uint32_t)(random_bits(&c->b->random) % count); }

static void add_light(struct city *c, enum light_class kind, vec3 position, vec3 direction, vec3 color, float intensity,
                      float range, float angle) {
    struct candidate light = {
        kind, c->candidates.count, vec3_distance(position, c->eye), position, direction, color, intensity, range, angle};
    if (!c->b->failed && !array_push(&c->b->scene->host, &c->candidates, light)) c->b->failed = true;
}

static void add_point(struct city *c, enum light_class kind, vec3 position, vec3 color, float intensity, float range) {
    add_light(c, kind, position, vec3_make(0, -1, 0), color, intensity, range, 0);
}

/* ---- houses ---- */

/** One house of a side: bays first .. end - 1. */
struct house {
    int first, end, floors, style;
};

struct side {
    struct house houses[6];
    int count;
};

/** The frame of one side of a block: where its facade's middle is, along it, and out of it. */
struct frame {
    vec3 middle, along, out;
    float yaw;
};

static vec3 frame_point(const struct frame *f, float x, float y, float z) {
    vec3 p = vec3_add_scaled(vec3_add_scaled(f->middle, f->along, x), f->out, z);
    return vec3_make(p.x, p.y + y, p.z);
}

static void place_in_frame(struct city *c, uint32_t mesh, const struct frame *f, float x, float y, float z, float turn) {
    vec3 p = frame_point(f, x, y, z);
    builtin_place(c->b, mesh, builtin_at(p.x, p.y, p.z, f->yaw + turn, 1));
}

static struct frame side_frame(float block_x, float block_z, int side) {
    float yaw = PI / 2 * (float)side;
    /* Exact axes: cosf(pi/2) is not quite zero. */
    const float sine[4] = {0, 1, 0, -1}, cosine[4] = {1, 0, -1, 0};
    vec3 out = {sine[side], 0, cosine[side]}, along = {cosine[side], 0, -sine[side]};
    return (struct frame){vec3_add_scaled(vec3_make(block_x, 0, block_z), out, CITY_BLOCK / 2), along, out, yaw};
}

/** Divides bays from .. to - 1 among houses of 3 to 5 bays. */
static void add_houses(struct city *c, struct side *side, int from, int to) {
    while (from < to) {
        int width = 3 + (int)choose(c, 3), left = to - from - width;
        if (left < 3) width = to - from;
        int style = (int)choose(c, CITY_STYLES);
        if (side->count && side->houses[side->count - 1].style == style) style = (style + 1) % CITY_STYLES;
        side->houses[side->count++] = (struct house){from, from + width, 4 + (int)choose(c, 3), style};
        from += width;
    }
}

static void place_window(struct city *c, const struct frame *f, const struct house *house, float x, float y) {
    bool lit = chance(c) < 0.42f;
    uint32_t kind = lit ? 2 + choose(c, CITY_WINDOWS - 2) : chance(c) < 0.3f;
    place_in_frame(c, c->meshes.windows[house->style][kind], f, x, y, 0, 0);
    if (lit) add_point(c, LIGHT_WINDOW, frame_point(f, x, y + 1.9f, 0.7f), LIGHT_WARM, 7, 4.5f);
}

static void place_ground_floor(struct city *c, const struct frame *f, const struct house *house, int bay, float x) {
    bool door = bay == house->first + (house->end - house->first) / 2;
    uint32_t kind = door ? 3 : chance(c) < 0.8f ? choose(c, 3) : 3;
    place_in_frame(c, c->meshes.shops[house->style][kind], f, x, CITY_KERB, 0, 0);
    if (kind == 3) {
        add_point(c, LIGHT_SHOP, frame_point(f, x - 0.78f, 3.0f, 0.35f), LIGHT_WARM, 14, 4);
        return;
    }
    add_point(c, LIGHT_SHOP, frame_point(f, x, 2.9f, -0.4f), LIGHT_NEUTRAL, 42, 7);
    if (chance(c) < 0.6f) {
        uint32_t sign = choose(c, CITY_SIGNS);
        place_in_frame(c, c->meshes.signs[sign], f, x + 1.6f, 4.3f, 0, 0);
        add_point(c, LIGHT_SIGN, frame_point(f, x + 1.6f, 5.1f, 0.6f), city_sign_colors[sign], 60, 9);
    }
}

/** Bays that a corner house of the neighbouring side owns have a facade here, but no roof and no back. */
static void place_house(struct city *c, const struct frame *f, const struct house *house, bool corner) {
    float top = CITY_KERB + CITY_GROUND + CITY_FLOOR * (float)house->floors;
    for (int bay = house->first; bay < house->end; bay++) {
        float x = ((float)bay + 0.5f) * CITY_BAY - CITY_BLOCK / 2;
        place_ground_floor(c, f, house, bay, x);
        for (int floor = 0; floor < house->floors; floor++) {
            float y = CITY_KERB + CITY_GROUND + CITY_FLOOR * (float)floor;
            place_window(c, f, house, x, y);
            if (house->style != 3 && floor % 2 && chance(c) < 0.35f) place_in_frame(c, c->meshes.balcony, f, x, y, 0, 0);
            if (!corner) place_in_frame(c, c->meshes.back, f, x, y, 0, 0);
        }
        place_in_frame(c, c->meshes.cornices[house->style], f, x, top, 0, 0);
        if ((bay - house->first) % 2 == 0 && house->style) { /* the better houses are lit from their first ledge */
            vec3 tint = house->style == 3 ? LIGHT_COOL : LIGHT_WARM;
            vec3 up = vec3_add_scaled(vec3_make(0, 1, 0), f->out, -0.22f);
            add_light(c, LIGHT_WASH, frame_point(f, x + CITY_BAY / 2, CITY_GROUND + 0.4f, 0.75f), up, tint, 150, 15, 0.75f);
        }
        if (corner) continue;
        place_in_frame(c, c->meshes.roof, f, x, top + 0.4f, 0, 0);
        place_in_frame(c, c->meshes.back, f, x, CITY_GROUND - CITY_FLOOR, 0, 0);
        place_in_frame(c, c->meshes.back, f, x, CITY_KERB, 0, 0);
    }
    for (int end = 0; end < 2 && !corner; end++) /* the walls towards lower neighbours */
        for (int floor = 2; floor < house->floors; floor++) {
            float x = (float)(end ? house->end : house->first) * CITY_BAY - CITY_BLOCK / 2 + (end ? -0.02f : 0.02f);
            place_in_frame(c, c->meshes.party, f, x, CITY_KERB + CITY_GROUND + CITY_FLOOR * (float)floor, 0, 0);
        }
}

static void place_block(struct city *c, float x, float z) {
    struct side sides[4] = {0};
    for (int s = 0; s < 4; s++)
        add_houses(c, &sides[s], s % 2 ? CITY_CORNER_BAYS : 0, CITY_BAYS - (s % 2 ? CITY_CORNER_BAYS : 0));
    for (int s = 0; s < 4; s++) {
        struct frame f = side_frame(x, z, s);
        for (int i = 0; i < sides[s].count; i++) place_house(c, &f, &sides[s].houses[i], false);
        if (s % 2 == 0) continue;
        const struct side *before = &sides[s - 1], *after = &sides[(s + 1) % 4];
        struct house first = before->houses[before->count - 1], last = after->houses[0];
        first.first = 0;
        first.end = CITY_CORNER_BAYS;
        last.first = CITY_BAYS - CITY_CORNER_BAYS;
        last.end = CITY_BAYS;
        place_house(c, &f, &first, true);
        place_house(c, &f, &last, true);
    }
    builtin_place(c->b, c->meshes.pavement, builtin_at(x, 0, z, 0, 1));
}

/* ---- streets ---- */

/** What stands on one side of one block's pavement; x along the facade, z from it to the road. */
static void place_pavement(struct city *c, const struct frame *f) {
    const float kerb = CITY_PAVEMENT - 0.65f, y = CITY_KERB, step = CITY_BLOCK / 4;
    struct city_meshes *m = &c->meshes;
    for (int i = 0; i < 4; i++) {
        float x = ((float)i + 0.5f) * step - CITY_BLOCK / 2;
        place_in_frame(c, m->lamp, f, x, y, kerb, 0);
        vec3 head = frame_point(f, x, 7.35f + y, kerb + 1.75f), lamp = vec3_lerp(LIGHT_WARM, LIGHT_NEUTRAL, 0.4f);
        add_light(c, LIGHT_LAMP, head, vec3_add_scaled(vec3_make(0, -1, 0), f->out, 0.12f), lamp, 1300, 20, 1.15f);
        add_point(c, LIGHT_LAMP, head, lamp, 420, 26);
        float lantern = x + step / 2;
        if (i < 3) {
            place_in_frame(c, m->lantern, f, lantern, y, kerb, 0);
            add_point(c, LIGHT_LANTERN, frame_point(f, lantern, 3.25f + y, kerb), LIGHT_WARM, 60, 9);
        }
        float tree = x - 0.27f * step;
        uint32_t kind = choose(c, COUNT_OF(m->tree));
        place_in_frame(c, m->tree[kind], f, tree, y, kerb - 0.25f, 2 * PI * chance(c));
        add_light(c, LIGHT_GARDEN, frame_point(f, tree + 0.4f, y + 0.1f, kerb - 0.9f), vec3_make(0, 1, 0), LIGHT_WARM, 28, 6,
                  0.8f);
        float spot = x + 1.3f;
        uint32_t what = choose(c, 4);
        if (what == 0) place_in_frame(c, m->bench, f, spot, y, kerb - 0.3f, PI);
        if (what == 1) place_in_frame(c, m->bin, f, spot, y, kerb - 0.1f, 0);
        if (what == 2) place_in_frame(c, m->planter, f, spot, y, kerb - 0.3f, 0);
    }
    for (int i = 0; i < 6; i++)
        for (int end = -1; end <= 1; end += 2)
            place_in_frame(c, m->bollard, f, (float)end * (CITY_BLOCK / 2 - 0.2f + 0.7f * (float)i), y, kerb + 0.2f, 0);
}

static void place_parked(struct city *c, const struct frame *f) {
    for (int i = 0; i < 8; i++) {
        if (chance(c) < 0.42f) continue;
        float x = -24.5f + 7 * (float)i, shift = 0.5f * (chance(c) - 0.5f);
        place_in_frame(c, c->meshes.cars[choose(c, CITY_PAINTS)], f, x + shift, 0, CITY_PAVEMENT + 1.15f + 0.1f * chance(c),
                       (chance(c) < 0.9f ? PI / 2 : -PI / 2) + 0.03f * (chance(c) - 0.5f));
    }
}

/** Traffic of one street segment; its frame's `out` is the direction of the street. */
static void place_traffic(struct city *c, const struct frame *street) {
    for (int i = 0; i < 4; i++) {
        float side = i & 1 ? 1.0f : -1.0f, along = -24 + 15.5f * (float)i + 9 * chance(c);
        if (chance(c) < 0.25f || along > 27) continue;
        /* They keep to the right: the one at x < 0 drives towards -out when `along` points right of `out`. */
        float turn = side > 0 ? 0 : PI, x = -1.9f * side, ahead = side > 0 ? 1.0f : -1.0f;
        place_in_frame(c, c->meshes.cars[choose(c, CITY_PAINTS)], street, x, 0, along, turn);
        place_in_frame(c, c->meshes.car_lights, street, x, 0, along, turn);
        vec3 forward = vec3_scale(street->out, ahead);
        for (int k = -1; k <= 1; k += 2) {
            vec3 head = frame_point(street, x + 0.62f * (float)k, 0.6f, along + 2.2f * ahead);
            add_light(c, LIGHT_CAR, head, vec3_add(forward, vec3_make(0, -0.09f, 0)), LIGHT_COOL, 2600, 22, 0.32f);
        }
        add_point(c, LIGHT_CAR, frame_point(street, x, 0.7f, along - 2.5f * ahead), vec3_make(1, 0.06f, 0.03f), 12, 4);
    }
}

static void place_strings(struct city *c, const struct frame *street) {
    for (int i = 0; i < 4; i++) {
        float along = -21 + 14 * (float)i;
        uint32_t kind = choose(c, 3) == 0;
        place_in_frame(c, c->meshes.string[kind], street, 0, 7.6f, along, 0);
        for (uint32_t k = 0; k < CITY_BULBS; k++) {
            vec3 bulb = city_bulb(k), color = kind ? city_sign_colors[k % 3] : LIGHT_WARM;
            add_point(c, LIGHT_STRING, frame_point(street, bulb.x, 7.6f + bulb.y - 0.1f, along), color, 16, 8);
        }
    }
}

/** One street segment beside a block: asphalt, traffic, strings across it. */
static void place_segment(struct city *c, float x, float z, bool along_x) {
    struct frame street = {{x, 0, z}, {1, 0, 0}, {0, 0, 1}, 0};
    if (along_x) street = (struct frame){{x, 0, z}, {0, 0, -1}, {1, 0, 0}, PI / 2};
    builtin_place(c->b, c->meshes.road, builtin_at(x, 0, z, street.yaw, 1));
    place_in_frame(c, c->meshes.manhole, &street, 1.2f, 0, 20 * (chance(c) - 0.5f), 0);
    place_traffic(c, &street);
    place_strings(c, &street);
}

static void place_crossing(struct city *c, float x, float z) {
    builtin_place(c->b, c->meshes.crossing, builtin_at(x, 0, z, 0, 1));
    for (int i = 0; i < 4; i++) {
        const float sine[4] = {0, 1, 0, -1}, cosine[4] = {1, 0, -1, 0};
        float reach = CITY_ROAD / 2 + 0.9f, go = (float)(i % 2);
        vec3 p = {x + reach * (cosine[i] + sine[i]), CITY_KERB, z + reach * (cosine[i] - sine[i])};
        builtin_place(c->b, c->meshes.traffic_light[i % 2], builtin_at(p.x, p.y, p.z, PI / 2 * (float)i, 1));
        vec3 lens = {p.x + 0.55f * sine[i], p.y + (go > 0 ? 2.7f : 3.25f), p.z + 0.55f * cosine[i]};
        add_point(c, LIGHT_SIGNAL, lens, go > 0 ? vec3_make(0.1f, 1, 0.45f) : vec3_make(1, 0.08f, 0.04f), 14, 5);
    }
}

static void place_streets(struct city *c) {
    float half = (float)c->blocks / 2;
    for (int i = 0; i <= c->blocks; i++)
        for (int k = 0; k <= c->blocks; k++) {
            float line = ((float)i - half) * CITY_PITCH, other = ((float)k - half) * CITY_PITCH,
                  middle = other + CITY_PITCH / 2;
            place_crossing(c, line, other);
            if (k == c->blocks) continue;
            place_segment(c, line, middle, false);
            place_segment(c, middle, line, true);
        }
}

/* ---- the town around ---- */

/** What a block of the surroundings may take: so many things, and no more once the scene has so many triangles. */
struct budget {
    uint64_t things, triangles;
};

static bool take_one(const struct city *c, struct budget *budget) {
    if (budget->things == 0 || c->b->placed_triangles >= budget->triangles) return false;
    budget->things--;
    return true;
}

/** Places far things for one block of the surroundings, the important ones first. */
static void place_far_block(struct city *c, float x, float z, struct budget budget) {
    struct city_meshes *m = &c->meshes;
    if (take_one(c, &budget)) builtin_place(c->b, m->far_block, builtin_at(x, 0, z, 0, 1));
    for (int i = 0; i < 4; i++) {
        float sx = i & 1 ? 14.5f : -14.5f, sz = i & 2 ? 14.5f : -14.5f;
        if (take_one(c, &budget))
            builtin_place(c->b, m->shells[choose(c, CITY_SHELLS)], builtin_at(x + sx, 0, z + sz, 0, 1));
    }
    for (int i = 0; i < 16 && take_one(c, &budget); i++) {
        struct frame f = side_frame(x, z, i % 4);
        place_in_frame(c, m->far_lamp, &f, ((float)(i / 4) - 1.5f) * 14, 0, 3.3f, 0);
    }
    for (int i = 0; i < 107 && take_one(c, &budget); i++) {
        struct frame f = side_frame(x, z, i % 4);
        bool tree = i < 24;
        float along = tree ? ((float)(i / 4) - 2.5f) * 9.3f : ((float)((i - 24) / 4) - 10) * 2.6f;
        place_in_frame(c, tree ? m->far_tree : m->bollard, &f, along, 0, tree ? 3.0f : 3.7f, 0);
    }
}

/**
 * Rings of blocks around the city: three, or as many as it takes to come to `wanted` things and `wanted_triangles` triangles in all. The
 * last thing may lead beyond the latter.
 */
static void place_surroundings(struct city *c, uint64_t wanted, uint64_t wanted_triangles) {
    const struct builtin *b = c->b;
    for (int ring = 1; ring <= 3 || b->placed < wanted || b->placed_triangles < wanted_triangles; ring++) {
        int reach = c->blocks + 2 * ring;
        for (int i = 0; i < reach; i++)
            for (int k = 0; k < reach; k++) {
                if (i > 0 && i < reach - 1 && k > 0 && k < reach - 1) continue;
                struct budget budget = {UINT64_MAX, UINT64_MAX};
                if (b->placed < wanted)
                    budget.things = wanted - b->placed;
                else if (b->placed_triangles < wanted_triangles)
                    budget.triangles = wanted_triangles;
                else
                    budget.things = ring > 3 ? 0 : wanted || wanted_triangles ? 5 : 21;
                float x = ((float)i - (float)(reach - 1) / 2) * CITY_PITCH,
                      z = ((float)k - (float)(reach - 1) / 2) * CITY_PITCH;
                /* The tower stands at the far end of the avenue, on a square. */
                if (ring == 1 && k == 0 && fabsf(x - c->avenue) < CITY_PITCH) budget.things = MIN(budget.things, 1u);
                place_far_block(c, x, z, budget);
            }
        if (b->failed) return;
    }
}

/* ---- lights ---- */

static int compare_candidates(const void *a, const void *b) {
    const struct candidate *x = a, *y = b;
    if (x->kind != y->kind) return x->kind < y->kind ? -1 : 1;
    if (x->distance != y->distance) return x->distance < y->distance ? -1 : 1;
    return x->index < y->index ? -1 : 1;
}

/** Random small lights in the streets, where they are seen; their range shrinks so that about 6 reach a point. */
static void fill_streets(struct city *c, uint64_t count) {
    struct builtin *b = c->b;
    const float width = CITY_ROAD + 2 * CITY_PAVEMENT - 1, height = 8;
    float length = CITY_PITCH * (float)c->blocks, streets = 2 * (float)(c->blocks + 1),
          volume = streets * length * width * height;
    float range = fminf(4, cbrtf(6 * volume * 3 / (4 * PI * (float)count)));
    for (uint64_t i = 0; i < count; i++) {
        float line =
            ((float)choose(c, (uint32_t)c->blocks + 1) - (float)c->blocks / 2) * CITY_PITCH + width * (chance(c) - 0.5f);
        float along = length * (chance(c) - 0.5f), y = 0.2f + height * chance(c) * chance(c);
        bool turned = random_bits(&b->random) & 1;
        vec3 color = vec3_lerp(LIGHT_WARM, city_sign_colors[choose(c, CITY_SIGNS)], 0.5f * chance(c));
        builtin_point(b, turned ? vec3_make(along, y, line) : vec3_make(line, y, along), color, 0.6f * range * range, range);
    }
}

static void place_lights(struct city *c, uint64_t count) {
    if (c->candidates.count) qsort(c->candidates.data, c->candidates.count, sizeof(*c->candidates.data), compare_candidates);
    uint64_t from_candidates = MIN(count, c->candidates.count);
    for (uint64_t i = 0; i < from_candidates; i++) {
        const struct candidate *l = &c->candidates.data[i];
        if (l->angle > 0)
            builtin_spot(c->b, l->position, l->direction, l->color, l->intensity, l->range, l->angle);
        else
            builtin_point(c->b, l->position, l->color, l->intensity, l->range);
    }
    fill_streets(c, count - from_candidates);
}

void builtin_make_city(struct builtin *b, const uint64_t *values) {
    struct city c = {.b = b, .blocks = (int)values[1]};
    b->random.state = values[2];
    float end = CITY_PITCH * (float)c.blocks / 2;
    c.avenue = c.blocks % 2 ? CITY_PITCH / 2 : 0;
    c.eye = vec3_make(c.avenue + 0.5f, 1.6f, end - 13);
    city_make_facades(b, &c.meshes);
    city_make_street(b, &c.meshes);
    city_make_vehicles(b, &c.meshes);
    city_make_skyline(b, &c.meshes);
    for (int i = 0; i < c.blocks && !b->failed; i++)
        for (int k = 0; k < c.blocks; k++) {
            float x = ((float)i - (float)(c.blocks - 1) / 2) * CITY_PITCH,
                  z = ((float)k - (float)(c.blocks - 1) / 2) * CITY_PITCH;
            place_block(&c, x, z);
            for (int s = 0; s < 4; s++) {
                struct frame f = side_frame(x, z, s);
                place_pavement(&c, &f);
                place_parked(&c, &f);
            }
        }
    place_streets(&c);
    builtin_place(b, c.meshes.tower, builtin_at(c.avenue, 0, -end - 40, 0, 1));
    for (int i = 0; i < 6; i++) { /* floodlights of the tower */
        vec3 p = {c.avenue + ((float)i - 2.5f) * 5, 1, -end - 22};
        add_light(&c, LIGHT_LAMP, p, vec3_sub(vec3_make(c.avenue, 22 + 4 * (float)(i % 3), -end - 35), p), LIGHT_WARM, 9000,
                  60, 0.4f);
    }
    place_surroundings(&c, values[3], values[4]);
    place_lights(&c, values[0]);
    array_free(&b->scene->host, &c.candidates);
    b->scene->ambient_sky = vec3_make(0.16f, 0.22f, 0.40f);
    b->scene->ambient_ground = vec3_make(0.12f, 0.09f, 0.07f);
    b->scene->background = vec3_make(0.07f, 0.11f, 0.26f);
    builtin_camera(b, "street", c.eye, vec3_make(c.avenue - 0.4f, 4.2f, end - 60), 0.82f);
    builtin_camera(b, "above", vec3_make(c.avenue + 34, 58, end + 34), vec3_make(c.avenue - 8, -8, end - 95), 0.9f);
}
