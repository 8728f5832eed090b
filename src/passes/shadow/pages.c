/* SPDX-License-Identifier: MIT */
#include "passes/shadow/pages.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/shadow/dark_shared.h"
#include "passes/shadow/pages_shared.h"
#include "passes/shadow/split_shared.h"
#include "shaders.h"

enum {
    CELL_PAGES = (SHADOW_PAGE / SHADOW_UNIT) * (SHADOW_PAGE / SHADOW_UNIT), /* that a cell of the atlas holds at most */
    ROWS_AT_FIRST = 64,
};

/* ---- what is kept ---- */

void shadow_state_finish(gpu_device *device, struct shadow_state *state) {
    for (int i = 0; i < 2; i++) {
        gpu_buffer_destroy(device, &state->held[i]);
        gpu_buffer_destroy(device, &state->before[i]);
        gpu_buffer_destroy(device, &state->pages[i]);
    }
    gpu_buffer_destroy(device, &state->shapes);
    gpu_buffer_destroy(device, &state->counts);
    gpu_buffer_destroy(device, &state->biases);
    gpu_buffer_destroy(device, &state->least);
    gpu_buffer_destroy(device, &state->split);
    gpu_image_destroy(device, &state->atlas);
    *state = (struct shadow_state){0};
}

void shadow_state_forget(struct shadow_state *state) { state->last.known = false; }

static uint32_t cell_count(uint32_t atlas_side) { return (atlas_side / SHADOW_PAGE) * (atlas_side / SHADOW_PAGE); }

static fnl_result create(gpu_device *device, struct shadow_state *state, uint32_t row_room, uint32_t atlas_side) {
    const uint64_t words = row_room * (uint64_t)SHADOW_ROW_WORDS * 4,
                   pages = cell_count(atlas_side) * (uint64_t)CELL_PAGES * sizeof(struct gpu_shadow_page);
    for (int i = 0; i < 2; i++) {
        TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow held", words, GPU_MEMORY_DEVICE, &state->held[i]));
        TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow before", words, GPU_MEMORY_DEVICE, &state->before[i]));
        TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow pages", pages, GPU_MEMORY_DEVICE, &state->pages[i]));
    }
    TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow shapes", row_room * sizeof(struct gpu_shape), GPU_MEMORY_DEVICE,
                          &state->shapes));
    TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow counts", sizeof(struct gpu_shadow_counts), GPU_MEMORY_DEVICE, &state->counts));
    TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow biases", row_room * 4ull, GPU_MEMORY_DEVICE, &state->biases));
    TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow split", row_room * sizeof(struct gpu_shadow_split_row), GPU_MEMORY_DEVICE, &state->split));
    const uint64_t blocks = atlas_side / SHADOW_DARK_BLOCK, squares = atlas_side / SHADOW_DARK_WIDE;
    TRY(gpu_buffer_create_for(device, GPU_USE_SHADOWS, "shadow least", (blocks * blocks + squares * squares) * 4, GPU_MEMORY_DEVICE, &state->least));
    const struct gpu_image_params atlas = {.name = "shadow atlas",
                                           .format = VK_FORMAT_D32_SFLOAT,
                                           .width = atlas_side,
                                           .height = atlas_side,
                                           .layers = 1,
                                           .mips = 1,
                                           .samples = 1,
                                           .use = GPU_USE_SHADOWS,
                                           .usage =
                                               VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
    TRY(gpu_image_create(device, &atlas, &state->atlas));
    state->row_room = row_room;
    return FNL_OK;
}

fnl_result shadow_pages_prepare(gpu_device *device, struct shadow_state *state, uint32_t row_count, uint32_t atlas_side) {
    REQUIRE(gpu_host(device), row_count >= 1 && row_count <= SHADOW_MOST_ROWS);
    REQUIRE(gpu_host(device), atlas_side >= SHADOW_PAGE && atlas_side % SHADOW_PAGE == 0);
    if (state->row_room >= row_count && state->atlas.params.width == atlas_side) return FNL_OK;
    uint32_t room = state->row_room;
    if (room < row_count) room = MIN(MAX(row_count + row_count / 4, (uint32_t)ROWS_AT_FIRST), SHADOW_MOST_ROWS);
    shadow_state_finish(device, state);
    fnl_result result = create(device, state, room, atlas_side);
    if (result != FNL_OK) shadow_state_finish(device, state);
    return result;
}

/* ---- a frame ---- */

/* What the steps pass on. */
struct build {
    struct graph *graph;
    const struct shadow_pages_input *input;
    struct shadow_pages out;
    graph_buffer rows;    /* a word for each light: SHADOW_ROW_… */
    graph_buffer tallies; /* pages by importance, bias and class */
    graph_buffer choice;  /* struct gpu_shadow_choice */
    graph_buffer rooms;   /* of SHADOW_ROOMS */
    graph_buffer cells;   /* struct gpu_shadow_cell */
    graph_buffer faces;   /* pages of each face, then those before it; and one more */
    graph_buffer places;  /* gpu_shadow_places.sums */
    graph_buffer traced;  /* a word for each row: 1: rays find its shadows. id 0: none is chosen to be */
    uint32_t split_rows; /* about which the last frame decided */
    uint32_t frames;     /* since the last that chose pages */
    uint32_t sun_rows, face_count, side, cell_count, block_count;
    struct {
        graph_buffer held, before, pages;
        uint32_t row_count; /* 0: there is no last frame */
    } last;
};

static graph_image add_atlas(struct graph *graph, const struct shadow_state *state) {
    const VkImageLayout layout = VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL;
    const bool clear = !state->last.cleared;
    graph_image atlas = graph_import_image(graph, &state->atlas, clear ? VK_IMAGE_LAYOUT_UNDEFINED : layout, layout);
    if (clear)
        graph_depth(graph_add_pass(graph, "shadow clear", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0), atlas,
                    VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return atlas;
}

/* How coarse the pages of each light are. */
static void add_choice(struct build *b) {
    struct graph *graph = b->graph;
    const struct light_set *lights = &b->input->lighting->lights;
    struct gpu_shadow_rows_push rows = {.row_count = b->out.row_count, .sun_rows = b->sun_rows, .updates = b->input->updates};
    rows.lighting = b->input->lighting->address;
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow rows",
                                        .pipeline = {.shader = &shader_pages_rows_comp},
                                        .groups = {DIVIDE_UP(b->out.row_count, 64u)},
                                        GRAPH_PUSH(rows),
                                        GRAPH_ROWS(graph_reads(NULL, lights->buffer), graph_changes(&rows.shapes, b->out.shapes),
                                                   graph_writes(&rows.rows, b->rows),
                                                   graph_row_if(b->sun_rows > 0, graph_reads(&rows.suns, b->input->suns)),
                                                   graph_row_if(b->sun_rows > 0 && b->input->keys.id, graph_reads(&rows.keys, b->input->keys)))});
    if (b->input->split)
        b->traced = shadow_split_add(graph, b->input->split,
                                     &(struct shadow_split_rows){.wanted = b->input->wanted,
                                                                 .rows = b->rows,
                                                                 .kept = b->out.split,
                                                                 .counts = b->out.split_counts,
                                                                 .row_count = b->out.row_count,
                                                                 .known_rows = b->split_rows,
                                                                 .sun_rows = b->sun_rows});
    struct gpu_shadow_count_push count = {.face_count = b->face_count};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow count",
                                                   .pipeline = {.shader = &shader_pages_count_comp},
                                                   .groups = {DIVIDE_UP(b->face_count, 64u)},
                                                   GRAPH_PUSH(count),
                                                   GRAPH_ROWS(graph_reads(&count.wanted, b->input->wanted),
                                                              graph_changes(&count.rows, b->rows),
                                                              graph_changes(&count.tallies, b->tallies))});
    struct gpu_shadow_pick_push pick = {.cell_count = b->cell_count, .fresh = b->last.row_count == 0};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow pick",
                                                   .pipeline = {.shader = &shader_pages_pick_comp},
                                                   .groups = {1},
                                                   GRAPH_PUSH(pick),
                                                   GRAPH_ROWS(graph_reads(&pick.tallies, b->tallies),
                                                              graph_writes(&pick.choice, b->choice),
                                                              graph_changes(&pick.counts, b->out.counts))});
}

/* The pages that pixels look up. */
static void add_wanted(struct build *b) {
    struct graph *graph = b->graph;
    struct gpu_shadow_hold_push hold = {.face_count = b->face_count, .last_rows = b->last.row_count, .sun_rows = b->sun_rows};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "shadow hold",
                              .pipeline = {.shader = &shader_pages_hold_comp},
                              .groups = {DIVIDE_UP(b->face_count, 64u)},
                              GRAPH_PUSH(hold),
                              GRAPH_ROWS(graph_reads(&hold.wanted, b->input->wanted), graph_reads(&hold.choice, b->choice),
                                         graph_changes(&hold.rows, b->rows), graph_changes(&hold.held, b->out.held),
                                         graph_writes(&hold.biases, b->out.biases), graph_writes(&hold.sums, b->faces),
                                         graph_changes(&hold.rooms, b->rooms), graph_reads(&hold.last_held, b->last.held),
                                         graph_changes(&hold.counts, b->out.counts),
                                         graph_row_if(b->traced.id > 0, graph_reads(&hold.traced, b->traced)))});
}

static void add_stay_step(const struct build *b, const char *name, const struct gpu_shader *shader) {
    struct gpu_shadow_stay_push push = {.side = b->side, .row_count = b->out.row_count, .frames = b->frames};
    graph_dispatch(b->graph,
                   &(struct graph_dispatch){
                       .name = name,
                       .pipeline = {.shader = shader},
                       .groups = {DIVIDE_UP(b->out.page_limit, 64u)},
                       GRAPH_PUSH(push),
                       GRAPH_ROWS(graph_changes(&push.last_pages, b->last.pages), graph_reads(&push.choice, b->choice),
                                  graph_reads(&push.rows, b->rows), graph_changes(&push.held, b->out.held),
                                  graph_changes(&push.sums, b->faces), graph_changes(&push.cells, b->cells))});
}

static void add_room_step(const struct build *b, const char *name, const struct gpu_shader *shader, uint32_t groups) {
    struct gpu_shadow_room_push push = {.cell_count = b->cell_count};
    graph_dispatch(b->graph, &(struct graph_dispatch){.name = name,
                                                      .pipeline = {.shader = shader},
                                                      .groups = {groups},
                                                      GRAPH_PUSH(push),
                                                      GRAPH_ROWS(graph_reads(&push.cells, b->cells),
                                                                 graph_changes(&push.rooms, b->rooms),
                                                                 graph_changes(&push.choice, b->choice))});
}

/* The pages of the last frame that stay beside them although nothing looks them up. */
static void add_idle(struct build *b) {
    add_stay_step(b, "shadow stay", &shader_pages_stay_comp);
    add_room_step(b, "shadow room", &shader_pages_room_comp, DIVIDE_UP(b->cell_count, 64u));
    add_room_step(b, "shadow fit", &shader_pages_fit_comp, 1);
    add_stay_step(b, "shadow keep", &shader_pages_keep_comp);
}

/* All pages, in order. */
static void add_list(struct build *b) {
    struct graph *graph = b->graph;
    prefix_sum_add(graph, "shadow faces", GRAPH_QUEUE_GRAPHICS, b->faces, b->face_count + 1);
    struct gpu_shadow_list_push list = {.face_count = b->face_count};
    graph_dispatch(graph,
                   &(struct graph_dispatch){
                       .name = "shadow list",
                       .pipeline = {.shader = &shader_pages_list_comp},
                       .groups = {DIVIDE_UP(b->face_count, 64u)},
                       GRAPH_PUSH(list),
                       GRAPH_ROWS(graph_reads(&list.held, b->out.held), graph_reads(&list.sums, b->faces),
                                  graph_writes(&list.before, b->out.before), graph_writes(&list.pages, b->out.pages))});
}

static struct graph_pass *add_place_step(const struct build *b, const char *name, const struct gpu_shader *shader,
                                         uint32_t groups, const void *push, size_t push_size,
                                         struct gpu_shadow_places *places, enum graph_use sums) {
    return graph_dispatch(
        b->graph, &(struct graph_dispatch){
                      .name = name,
                      .pipeline = {.shader = shader},
                      .groups = {groups},
                      .push = push,
                      .push_size = push_size,
                      GRAPH_ROWS(graph_changes(&places->pages, b->out.pages),
                                 graph_row_at(b->face_count * 4ull, graph_reads(&places->total, b->faces)),
                                 graph_changes(&places->cells, b->cells), graph_buffer_row(&places->sums, b->places, sums),
                                 graph_changes(&places->counts, b->out.counts), graph_reads(&places->choice, b->choice))});
}

/* Where they are. */
static void add_places(const struct build *b, uint32_t sum_count) {
    struct gpu_shadow_find_push find = {.places = {.block_count = b->block_count, .side = b->side},
                                        .row_count = b->last.row_count};
    struct graph_pass *pass = add_place_step(b, "shadow find", &shader_pages_find_comp, b->block_count, &find, sizeof find,
                                             &find.places, GRAPH_WRITE_COMPUTE);
    graph_add_row(pass, graph_reads(&find.held, b->last.held));
    graph_add_row(pass, graph_reads(&find.before, b->last.before));
    graph_add_row(pass, graph_reads(&find.pages, b->last.pages));
    struct gpu_shadow_place_push place = {find.places};
    add_place_step(b, "shadow cells", &shader_pages_cells_comp, DIVIDE_UP(b->cell_count, 64u), &place, sizeof place,
                   &place.places, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(b->graph, "shadow places", GRAPH_QUEUE_GRAPHICS, b->places, sum_count);
    add_place_step(b, "shadow place", &shader_pages_place_comp, b->block_count, &place, sizeof place, &place.places,
                   GRAPH_READ_COMPUTE);
}

/* What `state` keeps, as a frame uses it. */
static struct shadow_pages kept_pages(struct graph *graph, const struct shadow_state *state, uint32_t turn, uint32_t row_count) {
    const uint32_t side = state->atlas.params.width / SHADOW_PAGE;
    return (struct shadow_pages){.held = graph_import_buffer(graph, "shadow held", &state->held[turn]),
                                 .before = graph_import_buffer(graph, "shadow before", &state->before[turn]),
                                 .pages = graph_import_buffer(graph, "shadow pages", &state->pages[turn]),
                                 .biases = graph_import_buffer(graph, "shadow biases", &state->biases),
                                 .shapes = graph_import_buffer(graph, "shadow shapes", &state->shapes),
                                 .counts = graph_import_buffer(graph, "shadow counts", &state->counts),
                                 .least = graph_import_buffer(graph, "shadow least", &state->least),
                                 .atlas = add_atlas(graph, state),
                                 .row_count = row_count,
                                 .page_limit = side * side * CELL_PAGES};
}

struct shadow_pages shadow_pages_add(struct graph *graph, gpu_device *device, const struct shadow_state *state,
                                     const struct shadow_pages_input *input, struct shadow_turn *next) {
    const uint32_t last = state->last.turn, now = 1 - last, sun_rows = input->suns.id ? input->lighting->lights.directional_count * SHADOW_SUN_ROWS : 0,
                   row_count = sun_rows + input->lighting->lights.local_count, face_count = row_count * SHADOW_FACES, side = state->atlas.params.width / SHADOW_PAGE,
                   cells = side * side, page_limit = cells * CELL_PAGES, blocks = DIVIDE_UP(page_limit, SHADOW_BLOCK),
                   sum_count = 2 * SHADOW_CLASSES * blocks + (SHADOW_CLASSES + 1) * cells + 1;
    if (row_count > state->row_room) {
        gpu_fail(device, FNL_ERROR_INVALID);
        return (struct shadow_pages){0};
    }
    struct build b = {.graph = graph,
                      .input = input,
                      .out = kept_pages(graph, state, now, row_count),
                      .rows = graph_create_buffer(graph, "shadow rows", row_count * 4ull),
                      .tallies = graph_create_buffer(graph, "shadow tallies", SHADOW_TALLIES * 4ull),
                      .choice = graph_create_buffer(graph, "shadow choice", sizeof(struct gpu_shadow_choice)),
                      .rooms = graph_create_buffer(graph, "shadow rooms", (SHADOW_ROOMS + SHADOW_CLASSES) * 4ull),
                      .cells = graph_create_buffer(graph, "shadow cells", cells * sizeof(struct gpu_shadow_cell)),
                      .faces = graph_create_buffer(graph, "shadow faces", (face_count + 1) * 4ull),
                      .places = graph_create_buffer(graph, "shadow places", sum_count * 4ull),
                      .frames = state->last.kept + 1,
                      .sun_rows = sun_rows,
                      .face_count = face_count,
                      .side = side,
                      .cell_count = cells,
                      .block_count = blocks,
                      .last = {.held = graph_import_buffer(graph, "shadow last held", &state->held[last]),
                               .before = graph_import_buffer(graph, "shadow last before", &state->before[last]),
                               .pages = graph_import_buffer(graph, "shadow last pages", &state->pages[last]),
                               .row_count = state->last.known ? state->last.row_count : 0}};
    if (input->split) {
        b.out.split = graph_import_buffer(graph, "shadow split", &state->split);
        b.out.split_counts = graph_create_buffer(graph, "shadow split counts", sizeof(struct gpu_shadow_split_counts));
        b.split_rows = state->last.splits ? b.last.row_count : 0;
    }
    graph_add_clear(graph, "shadow tallies clear", GRAPH_QUEUE_GRAPHICS,
                    (struct graph_clear){.buffers = {b.tallies, b.rooms, b.cells}});
    graph_add_clear(graph, "shadow held clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {b.out.held}});
    add_choice(&b);
    add_wanted(&b);
    add_idle(&b);
    add_list(&b);
    add_places(&b, sum_count);
    *next = (struct shadow_turn){.row_count = row_count, .turn = now, .known = true, .cleared = true, .splits = input->split != NULL};
    return b.out;
}

struct shadow_pages shadow_pages_again(struct graph *graph, const struct shadow_state *state, struct shadow_turn *next) {
    *next = state->last;
    next->kept++;
    return kept_pages(graph, state, state->last.turn, state->last.row_count);
}
