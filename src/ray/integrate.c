/* SPDX-License-Identifier: MIT */
#include "ray/integrate.h"

#include "ray/environment.h"
#include "background_shared.h"
#include "scene/scene.h"

struct context {
    const struct ray_scene *scene;
    const fnl_trace_params *params;
    struct ray_samples *samples;
    struct ray_walk *walk;
    dvec3 sky, ground, background;
    const struct ray_environment *environment;
};

/* What a ray sees that leaves the scene. */
static dvec3 surroundings(const struct context *c, dvec3 direction) {
    return ray_environment_is(c->environment) ? ray_environment_from(c->environment, direction) : ray_sky(direction, c->sky, c->ground);
}

static double chance(const struct context *c) {
    double out;
    ray_samples_draw(c->samples, 1, &out);
    return out;
}

/* The environment about a direction, as wide as the blur says: from a lobe of GGX, each direction weighed by its cosine. */
static dvec3 blurred(const struct context *c, dvec3 direction) {
    enum { SAMPLES = 16 };
    const double alpha = fmin(BLUR_ALPHA(fmin((double)c->params->background_blur, BLUR_MOST) / 4), 1), alpha2 = alpha * alpha;
    dvec3 side, up, sum = {0, 0, 0};
    double weights = 0;
    dvec3_basis(direction, &side, &up);
    for (int i = 0; i < SAMPLES; i++) {
        double random[2];
        ray_samples_draw(c->samples, 2, random);
        const double u = (i + random[0]) / SAMPLES, cosine = 2 * (1 - u) / (1 + (alpha2 - 1) * u) - 1, sine = sqrt(fmax(1 - cosine * cosine, 0)), angle = 2 * DPI * random[1];
        if (!(cosine > 0)) continue;
        const dvec3 none = {0, 0, 0};
        const dvec3 to = dvec3_combine(side, up, none, dvec3_make(sine * cos(angle), sine * sin(angle), 1));
        sum = dvec3_add_scaled(sum, ray_environment_from(c->environment, dvec3_add_scaled(to, direction, cosine)), cosine);
        weights += cosine;
    }
    return dvec3_scale(sum, weights > 0 ? 1 / weights : 0);
}

static double smooth(double x) { return x * x * (3 - 2 * x); }

/* What the camera sees where no surface is, as frames show it (fnl_background). */
static dvec3 background(const struct context *c, dvec3 direction) {
    const bool has = ray_environment_is(c->environment);
    fnl_background kind = c->params->background;
    if (kind == FNL_BACKGROUND_AUTO) kind = has && c->environment->scene->staged ? FNL_BACKGROUND_GRADIENT : FNL_BACKGROUND_SCENE;
    if (kind == FNL_BACKGROUND_GRADIENT) {
        const double y = dvec3_normalize(direction).y, end = y > 0 ? GRADIENT_ZENITH : GRADIENT_NADIR;
        const double light = (has ? c->environment->mean : 1) * (GRADIENT_HORIZON + (end - GRADIENT_HORIZON) * smooth(fmin(fabs(y), 1)));
        return dvec3_make(light, light, light);
    }
    if (kind == FNL_BACKGROUND_BLUR && has) return blurred(c, direction);
    return has && c->environment->scene->background ? ray_environment_from(c->environment, direction) : c->background;
}

/* ---- direct light ---- */

static double light_visibility(const struct context *c, const struct ray_surface *lit, const struct ray_light *light,
                               dvec3 to_light, double distance) {
    enum { FAR = 1 }; /* metres: directional lights are aimed at over this */
    struct ray_surface turned = *lit;
    const struct ray_surface *s = &turned;
    if (ray_lets_through(lit) && dvec3_dot(lit->normal, to_light) < 0) turned.geometric = dvec3_scale(lit->geometric, -1);
    const bool infinite = isinf(distance);
    const double given = (double)(light->parallel ? c->params->sun_angle : c->params->light_radius), size = isinf(given) ? light->source : given;
    dvec3 to = ray_light_source(light, c->samples, size, s->position, to_light, infinite ? FAR : distance);
    if (!(dvec3_dot(s->geometric, dvec3_sub(to, s->position)) > 0))
        return 0; /* from behind the triangle, whatever its normals say */
    dvec3 origin = dvec3_add_scaled(s->position, s->geometric, s->offset), ray = dvec3_sub(to, infinite ? s->position : origin);
    double length = dvec3_length(ray),
           high = infinite ? (double)INFINITY : length - fmax(s->offset, ray_rounding(dvec3_reach(to)));
    if (!(high > 0)) return 1; /* the light lies on the surface */
    return ray_visibility(c->scene, RAY_LAMP, origin, dvec3_scale(ray, 1 / length), high, c->walk);
}

/* What the lights add; where `sum` is given, also what they would add without shadows. */
static dvec3 direct_light(const struct context *c, const struct ray_surface *s, dvec3 to_view, struct ray_sum *sum) {
    dvec3 out = {0, 0, 0};
    ray_scene_find_lights(c->scene, s->position, c->walk);
    for (uint32_t i = 0; i < c->walk->lights.count; i++) {
        const struct ray_light *l = ray_scene_light(c->scene, c->walk->lights.data[i]);
        dvec3 to_light;
        double distance;
        if (!(l->mask & s->light_mask)) continue;
        const double strength = ray_light_draw(l, c->samples, s->position, &to_light, &distance);
        if (!(strength > 0)) continue;
        dvec3 light = dvec3_scale(dvec3_mul(ray_brdf_cos(s, to_view, to_light), l->color), strength);
        if (!(dvec3_max(light) > 0)) continue;
        double visibility = c->params->shadows && l->casts_shadows ? light_visibility(c, s, l, to_light, distance) : 1;
        out = dvec3_add_scaled(out, light, visibility);
        if (!sum) continue;
        sum->unshadowed += dvec3_luminance(light);
        sum->direct += dvec3_luminance(light) * visibility;
    }
    return out;
}

/* ---- through surfaces ---- */

enum {
    SEEN_THROUGH = 16, /* surfaces */
    WITHIN = 64,       /* faces of volumes that reflect or refract a path on */
    TRIES = 4          /* microfacets that send light to the wrong side send it to others */
};

/* Light followed backward: from where, whither, and what part of it arrives. */
struct path {
    dvec3 origin, direction, carried;
    dvec3 absorption; /* within a volume */
    bool within;
    int channel; /* the one of three that dispersion has left over; -1: all */
    bool bent;   /* on the way from the last surface that reflected it */
    struct ray_hit hit; /* of follow() */
};

static dvec3 outgoing(const struct context *c, const struct ray_surface *s, dvec3 to_view, const struct path *seen_by, struct ray_sum *sum, uint32_t depth);

/* False: total reflection. `eta`: index on the side that light comes from over that behind; `normal` is on that side. */
static bool refract_at(dvec3 direction, dvec3 normal, double eta, dvec3 *out) {
    const double cosine = -dvec3_dot(direction, normal), sine2 = eta * eta * (1 - cosine * cosine);
    if (sine2 > 1) return false;
    *out = dvec3_normalize(dvec3_add_scaled(dvec3_scale(direction, eta), normal, eta * cosine - sqrt(1 - sine2)));
    return true;
}

static dvec3 attenuated(dvec3 absorption, double way) {
    return dvec3_make(exp(-absorption.x * way), exp(-absorption.y * way), exp(-absorption.z * way));
}

static dvec3 microfacet(const struct context *c, const struct ray_surface *s, dvec3 to_view) {
    double random[2];
    ray_samples_draw(c->samples, 2, random);
    return ray_microfacet_sample(s, to_view, random);
}

static bool is_volume(const struct ray_surface *s) { return s->layered && s->layers.transmission > 0 && s->layers.thickness > 0; }

/* Dispersion: a path goes on in one channel, which counts three times. */
static double ior_of(const struct context *c, const struct ray_layers *layers, struct path *p) {
    if (!(layers->dispersion > 0)) return layers->ior;
    if (p->channel < 0) {
        p->channel = (int)fmin(3 * chance(c), 2);
        p->carried = dvec3_mul(p->carried, dvec3_make(p->channel == 0 ? 3 : 0, p->channel == 1 ? 3 : 0, p->channel == 2 ? 3 : 0));
    }
    return fmax(layers->ior + (layers->ior - 1) * 0.025 * layers->dispersion * (p->channel - 1), 1);
}

/* Through the front of a surface: a sheet turns light as a mirror does, and to the other side; a volume refracts it. False: nothing comes. */
static bool pass(const struct context *c, const struct ray_surface *s, dvec3 to_view, struct path *p) {
    const dvec3 view = dvec3_scale(to_view, -1);
    p->bent = true;
    p->origin = dvec3_add_scaled(s->position, s->geometric, -s->offset);
    if (is_volume(s)) {
        p->within = true;
        p->absorption = s->layers.absorption;
        const double eta = 1 / ior_of(c, &s->layers, p);
        dvec3 h = microfacet(c, s, to_view);
        for (int i = 0; !refract_at(view, h, eta, &p->direction) || !(dvec3_dot(s->geometric, p->direction) < 0); i++) {
            if (i > TRIES) return false;
            h = i == TRIES ? s->normal : microfacet(c, s, to_view);
        }
        p->carried = dvec3_mul(p->carried, ray_through_weight(s, to_view, h));
        return dvec3_max(p->carried) > 0;
    }
    const dvec3 h = microfacet(c, s, to_view);
    p->carried = dvec3_mul(p->carried, ray_through_weight(s, to_view, h));
    const dvec3 mirrored = dvec3_add_scaled(view, h, -2 * dvec3_dot(view, h));
    const double n_l = dvec3_dot(s->normal, mirrored), alpha2 = fmax(pow(s->roughness, 4), 1e-6);
    if (!(n_l > 0)) return false;
    /* What microfacets shadow (by Smith) is not lost: it goes through others, and the whole lobe gets it back. */
    double albedo[2];
    ray_specular_albedo(c->environment->albedos, s->roughness, dvec3_dot(s->normal, to_view), albedo);
    p->carried = dvec3_scale(p->carried, 2 * n_l / (n_l + sqrt(alpha2 + (1 - alpha2) * n_l * n_l)) / (albedo[0] + albedo[1]));
    p->direction = dvec3_add_scaled(mirrored, s->normal, -2 * n_l);
    return dvec3_dot(s->geometric, p->direction) < 0 && dvec3_max(p->carried) > 0;
}

/* The next surface. Faces through which a volume is left refract, or reflect in full, and the path goes on: the model of glTF has the loss at the
   first face alone. False: it leaves the scene, or carries nothing any more. */
static bool follow(const struct context *c, struct path *p, enum ray_kind kind, struct ray_surface *s) {
    for (uint32_t i = 0; i < WITHIN; i++) {
        struct ray_hit hit;
        c->walk->key = random_bits(&c->samples->random);
        if (!ray_find(c->scene, p->within ? RAY_PATH : kind, p->origin, p->direction, 0, (double)INFINITY, NULL, c->walk, &hit)) {
            if (p->within) p->carried = dvec3_mul(p->carried, attenuated(p->absorption, (double)FLT_MAX));
            return false;
        }
        *s = ray_surface_at(c->scene, &hit, p->origin, p->direction, NULL);
        p->hit = hit;
        const bool leaves = !hit.front && (p->within || is_volume(s));
        if (leaves && is_volume(s)) p->absorption = s->layers.absorption;
        if (p->within || leaves) p->carried = dvec3_mul(p->carried, attenuated(p->absorption, hit.distance));
        if (!leaves) return true;
        p->bent = true;
        const double eta = s->layered ? ior_of(c, &s->layers, p) : 1;
        dvec3 out;
        bool found = false;
        for (int k = 0; k <= TRIES && !found; k++) {
            const dvec3 h = k == TRIES ? s->geometric : microfacet(c, s, dvec3_scale(p->direction, -1));
            const bool refracts = refract_at(p->direction, h, eta, &out);
            if (!refracts) out = dvec3_normalize(dvec3_add_scaled(p->direction, h, -2 * dvec3_dot(p->direction, h)));
            found = refracts == (dvec3_dot(s->geometric, out) < 0);
            p->within = !refracts;
        }
        p->direction = out;
        p->origin = dvec3_add_scaled(s->position, s->geometric, p->within ? s->offset : -s->offset);
    }
    p->carried = (dvec3){0, 0, 0};
    return false;
}

static dvec3 seen_through(const struct context *c, const struct ray_surface *s, dvec3 to_view, uint32_t depth) {
    const dvec3 none = {0, 0, 0};
    struct path p = {.carried = {1, 1, 1}, .channel = -1};
    struct ray_surface behind;
    if (depth >= SEEN_THROUGH || !pass(c, s, to_view, &p)) return none;
    if (follow(c, &p, RAY_THROUGH, &behind)) return dvec3_mul(p.carried, outgoing(c, &behind, dvec3_scale(p.direction, -1), &p, NULL, depth + 1));
    if (!(dvec3_max(p.carried) > 0)) return none;
    return dvec3_mul(p.carried, p.within ? surroundings(c, p.direction) : background(c, p.direction));
}

/* The chance that a path goes through a surface, rather than being reflected. */
static double chance_to_pass(const struct ray_surface *s, dvec3 to_view) {
    if (!s->layered || !(s->layers.transmission > 0)) return 0;
    const dvec3 weight = ray_through_weight(s, to_view, s->normal);
    const double through = dvec3_max(weight), base = dvec3_max(s->base_color), rest = base > 0 ? 1 - through / base : 1;
    return through > 0 ? through / (through + fmax(rest, 0.01)) : 0;
}

/* ---- paths ---- */

/* Where rays in a direction start; false: the surface itself is in the way. */
static bool start_of(const struct ray_surface *s, dvec3 direction, dvec3 *out) {
    const bool turned = ray_lets_through(s) && dvec3_dot(s->normal, direction) < 0;
    const dvec3 geometric = turned ? dvec3_scale(s->geometric, -1) : s->geometric;
    *out = dvec3_add_scaled(s->position, geometric, s->offset);
    return dvec3_dot(geometric, direction) > 0;
}

/* The two ways in which light is found, by chance of the surface or of what shines, share it by their densities (the balance heuristic, Veach 1997). */
static double share_of(double own, double other) { return own > 0 ? own / (own + other) : 0; }

/* Light that comes straight from bright parts of the environment: its share that is not left to the surface's own samples. */
static dvec3 aimed_at_environment(const struct context *c, const struct ray_surface *s, dvec3 to_view) {
    const dvec3 none = {0, 0, 0};
    double random[2], by_surface;
    dvec3 direction, start;
    ray_samples_draw(c->samples, 2, random);
    const double density = ray_environment_sample(c->environment, random, &direction);
    if (!(density > 0) || !start_of(s, direction, &start)) return none;
    const dvec3 reflected = dvec3_mul(ray_brdf_light(s, to_view, direction, &by_surface), ray_environment_from(c->environment, direction));
    if (!(dvec3_max(reflected) > 0)) return none;
    const double seen = ray_visibility(c->scene, RAY_PATH, start, direction, (double)INFINITY, c->walk);
    return dvec3_scale(reflected, seen * share_of(density, by_surface) / density);
}

/* The density per steradian with which a point of a glowing surface is chosen. */
static double emitter_density(double per_area, dvec3 geometric, dvec3 direction, double distance) {
    const double cosine = fabs(dvec3_dot(geometric, direction));
    return cosine > 0 ? per_area * distance * distance / cosine : 0;
}

/* The same of surfaces that glow. */
static dvec3 aimed_at_emitters(const struct context *c, const struct ray_surface *s, dvec3 to_view) {
    const dvec3 none = {0, 0, 0};
    double random[3], by_surface;
    struct ray_emitter_point at;
    ray_samples_draw(c->samples, 3, random);
    if (!ray_emitters_sample(c->scene, random, &at)) return none;
    dvec3 start;
    if (!start_of(s, dvec3_sub(at.position, s->position), &start)) return none;
    const dvec3 way = dvec3_sub(at.position, start);
    const double distance = dvec3_length(way);
    const dvec3 direction = dvec3_normalize(way);
    const double density = emitter_density(at.density, at.geometric, direction, distance);
    if (!(density > 0)) return none;
    /* Not to the triangle itself, which floats put nearer where it is seen from the side. */
    const double high = distance - fmax(s->offset, ray_rounding(dvec3_reach(at.position))) / fabs(dvec3_dot(at.geometric, direction));
    if (!(high > 0)) return none;
    const dvec3 reflected = ray_brdf_light(s, to_view, direction, &by_surface);
    if (!(dvec3_max(reflected) > 0)) return none;
    const double seen = ray_visibility(c->scene, RAY_PATH, start, direction, high, c->walk) * ray_scene_coverage(c->scene, &at.hit);
    if (!(seen > 0)) return none;
    at.hit.distance = distance;
    at.hit.front = dvec3_dot(at.geometric, direction) < 0;
    const dvec3 emissive = ray_surface_at(c->scene, &at.hit, start, direction, NULL).emissive;
    return dvec3_scale(dvec3_mul(reflected, emissive), seen * share_of(density, by_surface) / density);
}

/* Without bounces: of light from all around alone, what no surface stops. Going through a surface is no bounce. */
static dvec3 indirect_light(const struct context *c, const struct ray_surface *from, dvec3 to_view, const struct path *seen_by) {
    struct ray_surface s = *from;
    struct path p = {.carried = {1, 1, 1}, .channel = -1};
    dvec3 out = {0, 0, 0};
    uint32_t passed = 0;
    if (seen_by) p.within = seen_by->within, p.absorption = seen_by->absorption;
    for (uint32_t bounce = 0;; bounce++) {
        double random[3], density;
        ray_samples_next(c->samples);
        const bool aims = c->params->light_sampling && !p.within; /* what lies within glass is lit through it */
        if (aims && ray_environment_is(c->environment)) out = dvec3_add(out, dvec3_mul(p.carried, aimed_at_environment(c, &s, to_view)));
        if (aims && c->params->bounces > 0) out = dvec3_add(out, dvec3_mul(p.carried, aimed_at_emitters(c, &s, to_view)));
        ray_samples_draw(c->samples, 3, random);
        p.carried = dvec3_mul(p.carried, ray_brdf_sample(&s, to_view, random, &p.direction, &density));
        if (!(dvec3_max(p.carried) > 0)) return out;
        if (ray_lets_through(&s) && dvec3_dot(s.normal, p.direction) < 0) s.geometric = dvec3_scale(s.geometric, -1);
        if (!(dvec3_dot(s.geometric, p.direction) > 0)) return out;
        if (c->params->russian_roulette && bounce > 1) {
            double stays = fmin(dvec3_max(p.carried), 0.95);
            if (chance(c) >= stays) return out;
            p.carried = dvec3_scale(p.carried, 1 / stays);
        }
        p.origin = dvec3_add_scaled(s.position, s.geometric, s.offset);
        p.bent = false;
        for (bool passes = true; passes;) {
            if (!follow(c, &p, RAY_PATH, &s)) {
                if (!(dvec3_max(p.carried) > 0)) return out;
                const double share = aims && !p.bent ? share_of(density, ray_environment_density(c->environment, p.direction)) : 1;
                return dvec3_add(out, dvec3_mul(p.carried, dvec3_scale(surroundings(c, p.direction), share)));
            }
            to_view = dvec3_scale(p.direction, -1);
            s.lamps_shine_through = true;
            if (c->params->bounces > 0 && dvec3_max(s.emissive) > 0) {
                const double other = aims && !p.bent ? emitter_density(ray_emitters_density(c->scene, &p.hit), s.geometric, p.direction, p.hit.distance) : 0;
                out = dvec3_add(out, dvec3_mul(p.carried, dvec3_scale(s.emissive, share_of(density, other))));
            }
            ray_samples_next(c->samples);
            if (bounce < c->params->bounces) /* sources are seen from the last surface too, but not what others reflect */
                out = dvec3_add(out, dvec3_mul(p.carried, direct_light(c, &s, to_view, NULL)));
            const double passing = passed < SEEN_THROUGH ? chance_to_pass(&s, to_view) : 0;
            passes = passing > 0 && chance(c) < passing;
            p.carried = dvec3_scale(p.carried, 1 / (passes ? passing : 1 - passing));
            passed += passes;
            if (passes && !pass(c, &s, to_view, &p)) return out;
        }
        if (bounce == c->params->bounces) return out;
    }
}

/* `seen_by`: the path from which it is seen, or NULL; `depth`: surfaces that it is seen through. */
static dvec3 outgoing(const struct context *c, const struct ray_surface *s, dvec3 to_view, const struct path *seen_by, struct ray_sum *sum, uint32_t depth) {
    ray_samples_next(c->samples);
    dvec3 out = dvec3_add(s->emissive, direct_light(c, s, to_view, sum));
    if (s->layered && s->layers.transmission > 0) out = dvec3_add(out, seen_through(c, s, to_view, depth));
    if (c->params->bounces || ray_environment_is(c->environment)) return dvec3_add(out, indirect_light(c, s, to_view, seen_by));
    if (s->layered || s->conserving) return dvec3_add(out, ray_layers_ambient(c->environment->albedos, s, to_view, c->sky, c->ground));
    return dvec3_add(out, ray_ambient(s, to_view, c->sky, c->ground));
}

void ray_integrate(const struct ray_scene *scene, const fnl_trace_params *params, const struct ray_camera *camera, double x,
                   double y, struct ray_samples *samples, struct ray_walk *walk, struct ray_sum *sum) {
    struct context c = {.scene = scene, .params = params, .samples = samples, .walk = walk};
    dvec3 origin, direction, radiance = {0, 0, 0};
    double low, high, unused, rest = 1;
    struct ray_neighbours neighbours;
    struct ray_hit hit;
    ray_scene_surroundings(scene, &c.sky, &c.ground, &c.background);
    c.environment = ray_scene_environment(scene);
    ray_camera_ray(camera, x, y, &origin, &direction, &low, &high);
    const double step = 1 / sqrt(params->samples); /* each sample has its part of the pixel's textures, so that the mean is as sharp as a larger picture's */
    ray_camera_ray(camera, x + step, y, &neighbours.origin[0], &neighbours.direction[0], &unused, &unused);
    ray_camera_ray(camera, x, y + step, &neighbours.origin[1], &neighbours.direction[1], &unused, &unused);
    const bool found = ray_find(scene, RAY_CAMERA, origin, direction, low, high, &neighbours, walk, &hit);
    const dvec3 to_view = dvec3_scale(direction, -1);
    const uint32_t layer_count = walk->layers.count; /* the rays that follow do not touch them: they belong to paths */
    for (uint32_t i = 0; i < layer_count; i++) {
        struct ray_surface s = ray_surface_at(scene, &walk->layers.data[i], origin, direction, &neighbours);
        radiance = dvec3_add_scaled(radiance, outgoing(&c, &s, to_view, NULL, i == 0 ? sum : NULL, 0), rest * s.alpha);
        rest *= 1 - s.alpha;
    }
    sum->surfaces += found;
    if (found) {
        struct ray_surface s = ray_surface_at(scene, &hit, origin, direction, &neighbours);
        radiance = dvec3_add_scaled(radiance, outgoing(&c, &s, to_view, NULL, layer_count ? NULL : sum, 0), rest);
    } else {
        radiance = dvec3_add_scaled(radiance, background(&c, direction), rest);
    }
    sum->radiance = dvec3_add(sum->radiance, radiance);
}
