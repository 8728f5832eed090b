/* SPDX-License-Identifier: MIT */
/* Which pages the scene's materials have in the atlas of virtual texturing. */
#include "fanal/renderer.h"
#include "render/device/scene.h"

_Static_assert((int)VIRTUAL_FORWARD == (int)FNL_GBUFFER_COUNT, "behind the G-buffer layouts");
_Static_assert((int)SCENE_WRAP_REPEAT == VIRTUAL_REPEAT && (int)SCENE_WRAP_MIRROR == VIRTUAL_MIRROR &&
                   (int)SCENE_WRAP_CLAMP == VIRTUAL_CLAMP,
               "virtual_shared.h has the values of enum scene_wrap");

static bool is_smooth(const struct scene_sampler *s) {
    return s->mag == SCENE_FILTER_LINEAR && s->min == SCENE_FILTER_LINEAR && s->mip == SCENE_FILTER_LINEAR && s->mipmapped;
}

bool device_virtual_holds(const struct device_scene *d, const struct scene_material *m) {
    if (scene_material_layered(m)) return false;
    const struct scene_texture *first = NULL;
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        if (!device_has_texture(d, m, (enum scene_texture_slot)slot)) continue;
        const struct scene_texture *t = &m->textures[slot];
        const struct scene_sampler *s = &d->scene->samplers.data[t->sampler];
        if (!is_smooth(s)) return false;
        if (!first) {
            first = t;
            continue;
        }
        const struct scene_sampler *other = &d->scene->samplers.data[first->sampler];
        if (t->uv_set != first->uv_set || memcmp(t->transform, first->transform, sizeof t->transform) != 0 ||
            s->wrap_u != other->wrap_u || s->wrap_v != other->wrap_v)
            return false;
    }
    return true;
}

static uint32_t pages_along(uint32_t texels, uint32_t tier) {
    return DIVIDE_UP(MAX(texels >> VIRTUAL_STEP * tier, 1u), VIRTUAL_INNER);
}

static struct gpu_virtual_material describe(const struct device_scene *d, const struct scene_material *m, uint32_t *layers) {
    struct gpu_virtual_material g = {.width = 1, .height = 1, .transform = {1, 0, 0, 0, 1, 0}};
    if (m->alpha_mode == FNL_ALPHA_BLEND || !device_virtual_holds(d, m)) return g;
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        if (!device_has_texture(d, m, (enum scene_texture_slot)slot)) continue;
        const struct scene_texture *t = &m->textures[slot];
        const struct scene_sampler *s = &d->scene->samplers.data[t->sampler];
        const struct scene_image *image = &d->scene->images.data[t->image];
        g.width = MAX(g.width, image->width);
        g.height = MAX(g.height, image->height);
        g.wrap = (uint32_t)s->wrap_u | (uint32_t)s->wrap_v << 2;
        g.uv_set = t->uv_set;
        memcpy(g.transform, t->transform, sizeof g.transform);
        if (slot == SCENE_TEXTURE_EMISSIVE) *layers |= 1u << VIRTUAL_EMISSIVE;
        if (slot == SCENE_TEXTURE_SPECULAR_COLOR) *layers |= 1u << VIRTUAL_SPECULAR;
    }
    while (g.whole + 1 < VIRTUAL_TIERS && pages_along(g.width, g.whole) * pages_along(g.height, g.whole) > 1) g.whole++;
    g.tiers = g.whole + 1;
    while (g.tiers < VIRTUAL_TIERS && MAX(g.width, g.height) >> VIRTUAL_STEP * (g.tiers - 1) > 1) g.tiers++;
    return g;
}

/* Numbers the pages of a tier from *count on; `pages` may be NULL. */
static void number_pages(struct gpu_virtual_material *g, uint32_t material, uint32_t tier, uint32_t *count,
                         struct gpu_virtual_page *pages) {
    uint32_t across = pages_along(g->width, tier), down = pages_along(g->height, tier);
    g->first_page[tier] = *count;
    for (uint32_t i = 0; i < across * down; i++, (*count)++)
        if (pages) pages[*count] = (struct gpu_virtual_page){material, i % across | i / across << 14 | tier << 28};
}

/* The one page that holds all of a material first, of each; then coarse before fine. */
static uint32_t number_all(struct gpu_virtual_material *materials, uint32_t material_count, uint32_t *always,
                           struct gpu_virtual_page *pages) {
    uint32_t count = 0;
    for (uint32_t m = 0; m < material_count; m++)
        if (materials[m].tiers) number_pages(&materials[m], m, materials[m].whole, &count, pages);
    *always = count;
    for (uint32_t tier = VIRTUAL_TIERS; tier-- > 0;)
        for (uint32_t m = 0; m < material_count; m++)
            if (tier < materials[m].tiers && tier != materials[m].whole) number_pages(&materials[m], m, tier, &count, pages);
    return count;
}

fnl_result device_virtual_prepare(struct device_scene *d, uint32_t side, struct virtual_atlas *atlas) {
    const uint64_t arrivals = atlas->arrivals;
    atlas->arrivals = d->image_arrivals;
    if (atlas->version == d->texture_version && atlas->asked == side)
        return arrivals == d->image_arrivals ? FNL_OK : virtual_empty(d->device, atlas);
    virtual_destroy(d->device, atlas);
    uint32_t count = d->scene->materials.count + 1;
    struct scene_material standard = scene_material_default();
    struct virtual_contents contents = {.material_count = count, .side = side, .layers = (1u << VIRTUAL_EMISSIVE) - 1};
    struct gpu_virtual_material *materials = host_allocate(&d->host, count * sizeof *materials);
    if (!materials) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        materials[i] = describe(d, i + 1 < count ? &d->scene->materials.data[i] : &standard, &contents.layers);
    contents.page_count = number_all(materials, count, &contents.always, NULL);
    size_t size = contents.page_count * sizeof(struct gpu_virtual_page);
    struct gpu_virtual_page *pages = host_allocate(&d->host, size);
    fnl_result result = FNL_ERROR_MEMORY;
    if (pages) {
        number_all(materials, count, &contents.always, pages);
        contents.materials = materials;
        contents.pages = pages;
        result = virtual_create(d->device, &contents, atlas);
        host_free(&d->host, pages, size);
    }
    host_free(&d->host, materials, count * sizeof *materials);
    if (result == FNL_OK) atlas->version = d->texture_version;
    atlas->arrivals = d->image_arrivals;
    return result;
}
