/* SPDX-License-Identifier: MIT */
#include "gpu/specialise.h"

#include <string.h>

/* Numbers of the SPIR-V specification, version 1.6. */
enum {
    MAGIC = 0x07230203,
    HEADER_WORDS = 5,
    MOST_IDS = 1 << 22,
    OP_UNDEF = 1,
    OP_NAME = 5,
    OP_MEMBER_NAME = 6,
    OP_EXTENSION = 10,
    OP_EXT_INST_IMPORT = 11,
    OP_EXT_INST = 12,
    OP_ENTRY_POINT = 15,
    OP_EXECUTION_MODE = 16,
    OP_CAPABILITY = 17,
    OP_TYPE_VOID = 19,
    OP_TYPE_BOOL = 20,
    OP_TYPE_INT = 21,
    OP_TYPE_FLOAT = 22,
    OP_TYPE_POINTER = 32,
    OP_TYPE_FORWARD_POINTER = 39,
    OP_CONSTANT_TRUE = 41,
    OP_CONSTANT_FALSE = 42,
    OP_CONSTANT = 43,
    OP_CONSTANT_COMPOSITE = 44,
    OP_CONSTANT_NULL = 46,
    OP_SPEC_CONSTANT_TRUE = 48,
    OP_SPEC_CONSTANT_FALSE = 49,
    OP_SPEC_CONSTANT = 50,
    OP_SPEC_CONSTANT_COMPOSITE = 51,
    OP_SPEC_CONSTANT_OP = 52,
    OP_FUNCTION = 54,
    OP_FUNCTION_END = 56,
    OP_FUNCTION_CALL = 57,
    OP_VARIABLE = 59,
    OP_IMAGE_TEXEL_POINTER = 60,
    OP_LOAD = 61,
    OP_ACCESS_CHAIN = 65,
    OP_ARRAY_LENGTH = 68,
    OP_DECORATE = 71,
    OP_MEMBER_DECORATE = 72,
    OP_VECTOR_EXTRACT_DYNAMIC = 77,
    OP_COMPOSITE_EXTRACT = 81,
    OP_COPY_OBJECT = 83,
    OP_TRANSPOSE = 84,
    OP_SAMPLED_IMAGE = 86,
    OP_IMAGE_READ = 98,
    OP_IMAGE = 100,
    OP_IMAGE_QUERY_SAMPLES = 107,
    OP_CONVERT_F_TO_U = 109,
    OP_BITCAST = 124,
    OP_S_NEGATE = 126,
    OP_I_ADD = 128,
    OP_I_SUB = 130,
    OP_I_MUL = 132,
    OP_U_DIV = 134,
    OP_U_MOD = 137,
    OP_S_MUL_EXTENDED = 152,
    OP_ANY = 154,
    OP_LOGICAL_EQUAL = 164,
    OP_LOGICAL_NOT_EQUAL = 165,
    OP_LOGICAL_OR = 166,
    OP_LOGICAL_AND = 167,
    OP_LOGICAL_NOT = 168,
    OP_SELECT = 169,
    OP_I_EQUAL = 170,
    OP_I_NOT_EQUAL = 171,
    OP_U_GREATER_THAN = 172,
    OP_S_GREATER_THAN = 173,
    OP_U_GREATER_THAN_EQUAL = 174,
    OP_S_GREATER_THAN_EQUAL = 175,
    OP_U_LESS_THAN = 176,
    OP_S_LESS_THAN = 177,
    OP_U_LESS_THAN_EQUAL = 178,
    OP_S_LESS_THAN_EQUAL = 179,
    OP_F_UNORD_GREATER_THAN_EQUAL = 191,
    OP_SHIFT_RIGHT_LOGICAL = 194,
    OP_SHIFT_RIGHT_ARITHMETIC = 195,
    OP_SHIFT_LEFT_LOGICAL = 196,
    OP_BITWISE_OR = 197,
    OP_BITWISE_XOR = 198,
    OP_BITWISE_AND = 199,
    OP_NOT = 200,
    OP_BIT_COUNT = 205,
    OP_DPDX = 207,
    OP_FWIDTH_COARSE = 215,
    OP_ATOMIC_LOAD = 227,
    OP_ATOMIC_EXCHANGE = 229,
    OP_ATOMIC_XOR = 242,
    OP_PHI = 245,
    OP_LOOP_MERGE = 246,
    OP_SELECTION_MERGE = 247,
    OP_LABEL = 248,
    OP_BRANCH = 249,
    OP_BRANCH_CONDITIONAL = 250,
    OP_SWITCH = 251,
    OP_UNREACHABLE = 255,
    OP_DECORATE_ID = 332,
    OP_GROUP_ELECT = 333,
    OP_GROUP_QUAD_SWAP = 366,
    OP_COPY_LOGICAL = 400,
    OP_TERMINATE_INVOCATION = 4416,
    OP_CONVERT_U_TO_ACCELERATION_STRUCTURE = 4447,
    OP_IGNORE_INTERSECTION = 4448,
    OP_TERMINATE_RAY = 4449,
    OP_TYPE_RAY_QUERY = 4472,
    OP_RAY_QUERY_INITIALIZE = 4473,
    OP_RAY_QUERY_GET_INTERSECTION_TYPE = 4479,
    OP_EMIT_MESH_TASKS = 5294,
    OP_TYPE_ACCELERATION_STRUCTURE = 5341,
    OP_DECORATE_STRING = 5632,
    OP_MEMBER_DECORATE_STRING = 5633,
    OP_RAY_QUERY_GET_RAY_T_MIN = 6016,
    OP_RAY_QUERY_GET_WORLD_TO_OBJECT = 6032,
    CAPABILITY_RAY_QUERY = 4472,
    DECORATION_SPEC_ID = 1,
    STORAGE_INPUT = 1,
    STORAGE_OUTPUT = 3,
    MEMORY_VOLATILE = 1,
    EXT_MODF = 35,
    EXT_FREXP = 51,
};

/* What is known of an id: that it has several values or one that is not followed; its one value; or nothing yet, for no way to it was found. */
enum knowledge { ANYTHING, VALUE, NOTHING };

struct fact {
    enum knowledge knowledge;
    uint32_t value;
};

enum kind { OTHER, BOOL, INT, FLOAT }; /* types of 32 bits, and bools, whose values are followed */

enum use { UNUSED_ID, USED, GONE }; /* the last: it stood in a block that is dropped */

/* What stands in place of a block. The last two: the merge block or the continue target of a construct that stays, to which no way leads. */
enum fate { DROPPED, KEPT, NO_WAY_OUT, WAY_BACK };

struct block {
    uint32_t label, start, end; /* words, from its OpLabel to behind its last instruction */
    uint32_t last, merge;       /* of the instruction that ends it, and of its merge instruction or 0 */
    uint32_t header;            /* of the loop that it continues: WAY_BACK */
    enum fate fate;
};

struct work {
    const uint32_t *words;
    uint32_t count, bound, functions; /* words, ids, and where the first function begins */
    uint32_t constant_count;
    const struct gpu_constant *constants;
    uint32_t *defined;   /* per id: its instruction, or 0 */
    uint32_t *spec;      /* per id: 1 + SpecId, or 0 */
    uint32_t *blocks_of; /* per label: 1 + its block */
    struct fact *facts;
    unsigned char *used; /* enum use */
    uint32_t *line; /* ids whose instructions have to be marked */
    uint32_t line_count;
    struct block *blocks;
    uint32_t block_count;
    struct gpu_spirv out;
    uint32_t next_id;
    bool traces; /* some ray query is left */
};

static uint32_t length_at(const struct work *w, uint32_t at) { return w->words[at] >> 16; }
static uint32_t op_at(const struct work *w, uint32_t at) { return w->words[at] & 0xffff; }

static bool between(uint32_t op, uint32_t first, uint32_t last) { return op >= first && op <= last; }

/* Instructions that compute and change nothing: without a use they go. */
static bool is_pure(const struct work *w, uint32_t at) {
    const uint32_t op = op_at(w, at), length = length_at(w, at);
    const uint32_t *i = w->words + at;
    if (op == OP_LOAD) return length < 5 || !(i[4] & MEMORY_VOLATILE);
    if (op == OP_EXT_INST) return i[4] != EXT_MODF && i[4] != EXT_FREXP;
    return op == OP_UNDEF || op == OP_VARIABLE || op == OP_PHI || op == OP_COPY_LOGICAL || op == OP_IMAGE_TEXEL_POINTER ||
           between(op, OP_ACCESS_CHAIN, OP_ARRAY_LENGTH) || between(op, OP_VECTOR_EXTRACT_DYNAMIC, OP_TRANSPOSE) ||
           between(op, OP_SAMPLED_IMAGE, OP_IMAGE_READ) || between(op, OP_IMAGE, OP_IMAGE_QUERY_SAMPLES) ||
           between(op, OP_CONVERT_F_TO_U, OP_BITCAST) || between(op, OP_S_NEGATE, OP_S_MUL_EXTENDED) ||
           between(op, OP_ANY, OP_F_UNORD_GREATER_THAN_EQUAL) || between(op, OP_SHIFT_RIGHT_LOGICAL, OP_BIT_COUNT) ||
           between(op, OP_DPDX, OP_FWIDTH_COARSE) || op == OP_CONVERT_U_TO_ACCELERATION_STRUCTURE;
}

/* Where the result stands among the words of an instruction, or 0. (Results of rarer instructions are not followed; those are never dropped.) */
static uint32_t result_word(const struct work *w, uint32_t at) {
    const uint32_t op = op_at(w, at);
    if (op == OP_LABEL || op == OP_EXT_INST_IMPORT || between(op, OP_TYPE_VOID, OP_TYPE_FORWARD_POINTER - 1) || op == OP_TYPE_RAY_QUERY ||
        op == OP_TYPE_ACCELERATION_STRUCTURE)
        return 1;
    if (between(op, OP_CONSTANT_TRUE, OP_SPEC_CONSTANT_OP) || op == OP_FUNCTION_CALL || op == OP_LOAD || op == OP_EXT_INST ||
        op == OP_ATOMIC_LOAD || between(op, OP_ATOMIC_EXCHANGE, OP_ATOMIC_XOR) || between(op, OP_GROUP_ELECT, OP_GROUP_QUAD_SWAP) ||
        is_pure(w, at))
        return 2;
    return 0;
}

/* ---- reading ---- */

static bool is_last(uint32_t op) {
    return between(op, OP_BRANCH, OP_UNREACHABLE) || op == OP_TERMINATE_INVOCATION || op == OP_IGNORE_INTERSECTION || op == OP_TERMINATE_RAY ||
           op == OP_EMIT_MESH_TASKS;
}

/* Finds the instructions that define ids, and the blocks. False: not SPIR-V. */
static bool find_parts(struct work *w, bool counting) {
    struct block *block = NULL;
    w->block_count = 0;
    for (uint32_t at = HEADER_WORDS, length; at < w->count; at += length) {
        const uint32_t op = op_at(w, at);
        length = length_at(w, at);
        if (!length || length > w->count - at) return false;
        if (op == OP_FUNCTION && !w->functions) w->functions = at;
        if (counting) {
            w->block_count += op == OP_LABEL;
            continue;
        }
        const uint32_t result = result_word(w, at);
        if (result) {
            if (result >= length || w->words[at + result] >= w->bound) return false;
            w->defined[w->words[at + result]] = at;
            if (block && op != OP_LABEL) w->facts[w->words[at + result]].knowledge = NOTHING;
        }
        if (op == OP_DECORATE && length == 4 && w->words[at + 2] == DECORATION_SPEC_ID && w->words[at + 1] < w->bound)
            w->spec[w->words[at + 1]] = w->words[at + 3] + 1;
        if (op == OP_LABEL) {
            block = &w->blocks[w->block_count++];
            *block = (struct block){.label = w->words[at + 1], .start = at};
            w->blocks_of[block->label] = w->block_count;
        }
        if (!block) continue;
        if (op == OP_SELECTION_MERGE || op == OP_LOOP_MERGE) block->merge = at;
        block->end = at + length;
        block->last = at;
        if (is_last(op)) block = NULL;
    }
    return w->functions > 0 && !block;
}

static enum kind kind_of(const struct work *w, uint32_t type) {
    if (type >= w->bound || !w->defined[type]) return OTHER;
    const uint32_t *i = w->words + w->defined[type];
    switch (i[0] & 0xffff) {
        case OP_TYPE_BOOL: return BOOL;
        case OP_TYPE_INT: return i[2] == 32 ? INT : OTHER;
        case OP_TYPE_FLOAT: return i[2] == 32 ? FLOAT : OTHER;
        default: return OTHER;
    }
}

static struct block *find_block(const struct work *w, uint32_t label) { return &w->blocks[w->blocks_of[label] - 1]; }

/* ---- constants ---- */

static const struct fact anything = {ANYTHING, 0};

static struct fact value_fact(uint32_t value) { return (struct fact){VALUE, value}; }

static bool compare(uint32_t op, uint32_t a, uint32_t b) {
    const int32_t sa = (int32_t)a, sb = (int32_t)b;
    switch (op) {
        case OP_LOGICAL_EQUAL:
        case OP_I_EQUAL: return a == b;
        case OP_LOGICAL_NOT_EQUAL:
        case OP_I_NOT_EQUAL: return a != b;
        case OP_U_GREATER_THAN: return a > b;
        case OP_S_GREATER_THAN: return sa > sb;
        case OP_U_GREATER_THAN_EQUAL: return a >= b;
        case OP_S_GREATER_THAN_EQUAL: return sa >= sb;
        case OP_U_LESS_THAN: return a < b;
        case OP_S_LESS_THAN: return sa < sb;
        case OP_U_LESS_THAN_EQUAL: return a <= b;
        default: return sa <= sb;
    }
}

static struct fact fold_numbers(uint32_t op, uint32_t a, uint32_t b) {
    switch (op) {
        case OP_I_ADD: return value_fact(a + b);
        case OP_I_SUB: return value_fact(a - b);
        case OP_I_MUL: return value_fact(a * b);
        case OP_U_DIV: return b ? value_fact(a / b) : anything;
        case OP_U_MOD: return b ? value_fact(a % b) : anything;
        case OP_BITWISE_AND: return value_fact(a & b);
        case OP_BITWISE_OR: return value_fact(a | b);
        case OP_BITWISE_XOR: return value_fact(a ^ b);
        case OP_SHIFT_LEFT_LOGICAL: return b < 32 ? value_fact(a << b) : anything;
        case OP_SHIFT_RIGHT_LOGICAL: return b < 32 ? value_fact(a >> b) : anything;
        default: return anything;
    }
}

/* The result of an operation of two operands. One of them may be enough to know it. */
static struct fact fold(uint32_t op, struct fact a, struct fact b) {
    const bool a_none = a.knowledge == VALUE && a.value == 0, b_none = b.knowledge == VALUE && b.value == 0;
    if ((op == OP_LOGICAL_AND || op == OP_BITWISE_AND || op == OP_I_MUL) && (a_none || b_none)) return value_fact(0);
    if (op == OP_LOGICAL_OR && ((a.knowledge == VALUE && a.value) || (b.knowledge == VALUE && b.value))) return value_fact(1);
    if (a.knowledge == NOTHING || b.knowledge == NOTHING) return (struct fact){NOTHING, 0};
    if (a.knowledge == ANYTHING || b.knowledge == ANYTHING) return anything;
    if (op == OP_LOGICAL_AND) return value_fact(a.value && b.value);
    if (op == OP_LOGICAL_OR) return value_fact(a.value || b.value);
    if (op == OP_LOGICAL_EQUAL || op == OP_LOGICAL_NOT_EQUAL || between(op, OP_I_EQUAL, OP_S_LESS_THAN_EQUAL))
        return value_fact(compare(op, a.value, b.value));
    return fold_numbers(op, a.value, b.value);
}

/* Of an operation whose operands start at this word: `operands` of them. */
static struct fact evaluate(const struct work *w, uint32_t op, uint32_t type, uint32_t at, uint32_t operands) {
    const enum kind kind = kind_of(w, type);
    const uint32_t *ids = w->words + at;
    if (kind == OTHER) return anything;
    if (op == OP_SELECT && operands == 3) {
        const struct fact condition = w->facts[ids[0]];
        return condition.knowledge == VALUE ? w->facts[ids[condition.value ? 1 : 2]] : condition;
    }
    if (op == OP_COPY_OBJECT && operands == 1) return w->facts[ids[0]];
    if (op == OP_BITCAST && operands == 1) return w->facts[ids[0]]; /* others than scalars of 32 bits are never known */
    if (op == OP_COMPOSITE_EXTRACT && operands == 2 && w->defined[ids[0]]) {
        const uint32_t *whole = w->words + w->defined[ids[0]], made = whole[0] & 0xffff;
        const bool constant = made == OP_CONSTANT_COMPOSITE || made == OP_SPEC_CONSTANT_COMPOSITE;
        return constant && 3 + ids[1] < whole[0] >> 16 ? w->facts[whole[3 + ids[1]]] : anything;
    }
    if (kind == FLOAT) return anything;
    if (op == OP_LOGICAL_NOT || op == OP_NOT || op == OP_S_NEGATE) {
        struct fact a = w->facts[ids[0]];
        if (a.knowledge == VALUE) a.value = op == OP_LOGICAL_NOT ? !a.value : op == OP_NOT ? ~a.value : 0u - a.value;
        return a;
    }
    const bool known = between(op, OP_LOGICAL_EQUAL, OP_LOGICAL_AND) || between(op, OP_I_EQUAL, OP_S_LESS_THAN_EQUAL) || op == OP_I_ADD ||
                       op == OP_I_SUB || op == OP_I_MUL || op == OP_U_DIV || op == OP_U_MOD ||
                       (between(op, OP_SHIFT_RIGHT_LOGICAL, OP_BITWISE_AND) && op != OP_SHIFT_RIGHT_ARITHMETIC);
    return known && operands == 2 ? fold(op, w->facts[ids[0]], w->facts[ids[1]]) : anything;
}

static uint32_t given_value(const struct work *w, uint32_t id, uint32_t otherwise) {
    for (uint32_t i = 0; w->spec[id] && i < w->constant_count; i++)
        if (w->constants[i].id == w->spec[id] - 1) return w->constants[i].value;
    return otherwise;
}

/* Of constants, which stand before all functions. */
static void read_constants(struct work *w) {
    for (uint32_t at = HEADER_WORDS; at < w->functions; at += length_at(w, at)) {
        const uint32_t op = op_at(w, at), length = length_at(w, at), *i = w->words + at;
        if (!between(op, OP_CONSTANT_TRUE, OP_SPEC_CONSTANT_OP)) continue;
        const enum kind kind = kind_of(w, i[1]);
        struct fact fact = anything;
        if (op == OP_CONSTANT_TRUE || op == OP_SPEC_CONSTANT_TRUE) fact = value_fact(given_value(w, i[2], 1) != 0);
        else if (op == OP_CONSTANT_FALSE || op == OP_SPEC_CONSTANT_FALSE) fact = value_fact(given_value(w, i[2], 0) != 0);
        else if ((op == OP_CONSTANT || op == OP_SPEC_CONSTANT) && kind != OTHER) fact = value_fact(given_value(w, i[2], i[3]));
        else if (op == OP_CONSTANT_NULL && kind != OTHER) fact = value_fact(0);
        else if (op == OP_SPEC_CONSTANT_OP && length > 4) fact = evaluate(w, i[3], i[1], at + 4, length - 4);
        w->facts[i[2]] = fact;
    }
}

/* ---- branches ---- */

/* A branch back to the start of a loop stays as it is: each loop has one. */
static bool goes_back(const struct work *w, const struct block *block) {
    for (uint32_t k = 2; k < 4; k++)
        if (find_block(w, w->words[block->last + k]) <= block) return true;
    return false;
}

/* Where a block leads to when that is known, or 0. */
static uint32_t known_target(const struct work *w, const struct block *block) {
    const uint32_t *last = w->words + block->last, op = last[0] & 0xffff, length = last[0] >> 16;
    if (op == OP_BRANCH) return last[1];
    if (op != OP_BRANCH_CONDITIONAL && op != OP_SWITCH) return 0;
    const struct fact fact = w->facts[last[1]];
    if (fact.knowledge != VALUE) return 0;
    if (op == OP_BRANCH_CONDITIONAL) return goes_back(w, block) ? 0 : last[fact.value ? 2 : 3];
    for (uint32_t k = 3; k + 1 < length; k += 2)
        if (last[k] == fact.value) return last[k + 1];
    return last[2];
}

/* The k-th label that a block may lead to, or 0. Until something is known of the condition it leads nowhere. */
static uint32_t target_at(const struct work *w, const struct block *block, uint32_t k) {
    const uint32_t *last = w->words + block->last, op = last[0] & 0xffff, length = last[0] >> 16, known = known_target(w, block);
    if (known) return k == 0 ? known : 0;
    if (op == OP_BRANCH_CONDITIONAL) return k < 2 && w->facts[last[1]].knowledge != NOTHING ? last[2 + k] : 0;
    if (op == OP_SWITCH && w->facts[last[1]].knowledge != NOTHING) return k == 0 ? last[2] : 2 * k + 2 < length ? last[2 * k + 2] : 0;
    return 0;
}

static bool leads_to(const struct work *w, uint32_t from, uint32_t label) {
    const struct block *block = find_block(w, from);
    if (block->fate != KEPT) return false;
    for (uint32_t k = 0, target; (target = target_at(w, block, k)); k++)
        if (target == label) return true;
    return false;
}

/* What the ways that are open bring. */
static struct fact merge_ways(const struct work *w, uint32_t at, uint32_t label) {
    struct fact fact = {NOTHING, 0};
    if (kind_of(w, w->words[at + 1]) == OTHER) return anything;
    for (uint32_t k = 3; k + 1 < length_at(w, at); k += 2) {
        const struct fact here = w->facts[w->words[at + k]];
        if (here.knowledge == NOTHING || !leads_to(w, w->words[at + k + 1], label)) continue;
        if (here.knowledge == ANYTHING || (fact.knowledge == VALUE && fact.value != here.value)) return anything;
        fact = here;
    }
    return fact;
}

/* Follows a block that can be reached; whether that taught anything. Facts only go one way: from NOTHING to VALUE to ANYTHING. */
static bool follow(struct work *w, const struct block *block) {
    bool learned = false;
    for (uint32_t at = block->start; at < block->last; at += length_at(w, at)) {
        const uint32_t op = op_at(w, at), *i = w->words + at;
        if (op == OP_LABEL || !result_word(w, at)) continue;
        struct fact *fact = &w->facts[i[2]], now;
        if (fact->knowledge == ANYTHING) continue;
        now = op == OP_PHI ? merge_ways(w, at, block->label) : evaluate(w, op, i[1], at + 3, (i[0] >> 16) - 3);
        if (now.knowledge == fact->knowledge && now.value == fact->value) continue;
        *fact = fact->knowledge == NOTHING ? now : anything;
        learned = true;
    }
    for (uint32_t k = 0, target; (target = target_at(w, block, k)); k++) {
        struct block *next = find_block(w, target);
        learned |= next->fate != KEPT;
        next->fate = KEPT;
    }
    return learned;
}

static void find_ways(struct work *w) {
    for (uint32_t at = w->functions; at < w->count; at += length_at(w, at))
        if (op_at(w, at) == OP_FUNCTION) {
            uint32_t first = at;
            while (first < w->count && op_at(w, first) != OP_LABEL && op_at(w, first) != OP_FUNCTION_END) first += length_at(w, first);
            if (first < w->count && op_at(w, first) == OP_LABEL) find_block(w, w->words[first + 1])->fate = KEPT;
        }
    for (bool learned = true; learned;) {
        learned = false;
        for (uint32_t b = 0; b < w->block_count; b++)
            if (w->blocks[b].fate == KEPT) learned |= follow(w, &w->blocks[b]);
    }
    /* Constructs that stay name blocks, which have to be there. */
    for (uint32_t b = 0; b < w->block_count; b++) {
        const struct block *block = &w->blocks[b];
        if (block->fate != KEPT || !block->merge) continue;
        const bool loop = op_at(w, block->merge) == OP_LOOP_MERGE;
        if (!loop && op_at(w, block->last) != OP_SWITCH && known_target(w, block)) continue;
        struct block *merge = find_block(w, w->words[block->merge + 1]);
        if (merge->fate == DROPPED) merge->fate = NO_WAY_OUT;
        if (!loop) continue;
        struct block *next = find_block(w, w->words[block->merge + 2]);
        if (next->fate == KEPT) continue;
        next->fate = WAY_BACK;
        next->header = block->label;
    }
}

/* ---- uses ---- */

static void use(struct work *w, uint32_t id) {
    if (id >= w->bound || w->used[id] != UNUSED_ID) return; /* words that are no ids do no harm */
    w->used[id] = USED;
    w->line[w->line_count++] = id;
}

static bool is_folded(const struct work *w, uint32_t id) { return w->defined[id] >= w->functions && w->facts[id].knowledge == VALUE; }

static uint32_t chosen_operand(const struct work *w, uint32_t at) { /* of OpSelect with a known condition, or 0 */
    const struct fact condition = w->facts[w->words[at + 3]];
    return condition.knowledge == VALUE ? w->words[at + (condition.value ? 4 : 5)] : 0;
}

static void use_operands(struct work *w, uint32_t at) {
    const uint32_t op = op_at(w, at), length = length_at(w, at), *i = w->words + at;
    if (op == OP_PHI) {
        use(w, i[1]);
        for (uint32_t k = 3; k + 1 < length; k += 2)
            if (find_block(w, i[k + 1])->fate == KEPT) use(w, i[k]);
    } else if (op == OP_SELECT && chosen_operand(w, at)) {
        use(w, i[1]);
        use(w, chosen_operand(w, at));
    } else
        for (uint32_t k = 1; k < length; k++) use(w, i[k]);
}

static bool is_interface(const struct work *w, uint32_t id) {
    const uint32_t *i = w->words + w->defined[id];
    return w->defined[id] && (i[0] & 0xffff) == OP_VARIABLE && (i[3] == STORAGE_INPUT || i[3] == STORAGE_OUTPUT);
}

static uint32_t name_end(const struct work *w, uint32_t at) { /* of OpEntryPoint: behind the word with the end of its name */
    uint32_t k = at + 3;
    while (k + 1 < at + length_at(w, at) && (w->words[k] & 0xff) && (w->words[k] & 0xff00) && (w->words[k] & 0xff0000) && w->words[k] >> 24) k++;
    return k + 1;
}

static bool is_annotation(uint32_t op) {
    return op == OP_NAME || op == OP_MEMBER_NAME || op == OP_DECORATE || op == OP_MEMBER_DECORATE || op == OP_DECORATE_ID ||
           op == OP_DECORATE_STRING || op == OP_MEMBER_DECORATE_STRING;
}

static void forget_dropped(struct work *w) {
    for (uint32_t b = 0; b < w->block_count; b++)
        for (uint32_t at = w->blocks[b].start; w->blocks[b].fate != KEPT && at < w->blocks[b].end; at += length_at(w, at)) {
            const uint32_t result = result_word(w, at);
            if (result && (op_at(w, at) != OP_LABEL || w->blocks[b].fate == DROPPED)) w->used[w->words[at + result]] = GONE;
        }
}

static void find_uses(struct work *w) {
    forget_dropped(w);
    for (uint32_t at = HEADER_WORDS; at < w->functions; at += length_at(w, at)) {
        const uint32_t op = op_at(w, at);
        if (op == OP_ENTRY_POINT) {
            for (uint32_t k = name_end(w, at); k < at + length_at(w, at); k++)
                if (w->words[k] < w->bound && is_interface(w, w->words[k])) use(w, w->words[k]);
        } else if ((op == OP_EXECUTION_MODE || op > OP_CAPABILITY) && !is_annotation(op) && op != OP_TYPE_FORWARD_POINTER && !result_word(w, at))
            use_operands(w, at); /* sizes of work groups, types of extensions … */
    }
    for (uint32_t at = w->functions, length; at < w->count; at += length) {
        length = length_at(w, at);
        if (op_at(w, at) != OP_LABEL) {
            use_operands(w, at); /* a function and its parameters */
            continue;
        }
        const struct block *block = find_block(w, w->words[at + 1]);
        length = block->end - block->start;
        if (block->fate != KEPT) continue;
        for (uint32_t k = block->start; k < block->end; k += length_at(w, k))
            if (k != block->last && op_at(w, k) != OP_LABEL && k != block->merge && !is_pure(w, k)) use_operands(w, k);
        const uint32_t op = op_at(w, block->last);
        if ((op == OP_BRANCH_CONDITIONAL && !known_target(w, block)) || op == OP_SWITCH) use(w, w->words[block->last + 1]);
        if (!between(op, OP_BRANCH, OP_SWITCH)) use_operands(w, block->last); /* a value that is returned … */
    }
    while (w->line_count) {
        const uint32_t id = w->line[--w->line_count], at = w->defined[id];
        if (!at || op_at(w, at) == OP_LABEL) continue;
        if (w->facts[id].knowledge == VALUE) use(w, w->words[at + 1]); /* its type: it is a constant now */
        else use_operands(w, at);
    }
}

/* ---- ray queries: devices without them cannot have so much as their types ---- */

static bool is_of_queries(const struct work *w, uint32_t at) {
    const uint32_t op = op_at(w, at), *i = w->words + at;
    if (op == OP_TYPE_POINTER) return i[3] < w->bound && w->defined[i[3]] && is_of_queries(w, w->defined[i[3]]);
    if (op == OP_VARIABLE) return i[1] < w->bound && w->defined[i[1]] && is_of_queries(w, w->defined[i[1]]);
    return op == OP_TYPE_RAY_QUERY || op == OP_TYPE_ACCELERATION_STRUCTURE || op == OP_CONVERT_U_TO_ACCELERATION_STRUCTURE;
}

/* Where no query is left, so is nothing that is made for them: other instructions may have words that look like their ids. */
static void find_queries(struct work *w) {
    for (uint32_t b = 0; b < w->block_count && !w->traces; b++)
        for (uint32_t at = w->blocks[b].start; w->blocks[b].fate == KEPT && at < w->blocks[b].end; at += length_at(w, at))
            w->traces |= between(op_at(w, at), OP_RAY_QUERY_INITIALIZE, OP_RAY_QUERY_GET_INTERSECTION_TYPE) ||
                         between(op_at(w, at), OP_RAY_QUERY_GET_RAY_T_MIN, OP_RAY_QUERY_GET_WORLD_TO_OBJECT);
    for (uint32_t at = HEADER_WORDS; !w->traces && at < w->count; at += length_at(w, at))
        if (is_of_queries(w, at)) w->used[w->words[at + result_word(w, at)]] = GONE;
}

static bool is_need_of_queries(const struct work *w, uint32_t at) {
    static const char name[] = "SPV_KHR_ray_query";
    if (op_at(w, at) == OP_CAPABILITY) return w->words[at + 1] == CAPABILITY_RAY_QUERY;
    return op_at(w, at) == OP_EXTENSION && (length_at(w, at) - 1) * sizeof(uint32_t) >= sizeof name &&
           memcmp(w->words + at + 1, name, sizeof name) == 0;
}

/* ---- writing ---- */

static void put(struct work *w, uint32_t word) { w->out.words[w->out.count++] = word; }

static void put_instruction(struct work *w, uint32_t at) {
    for (uint32_t k = 0; k < length_at(w, at); k++) put(w, w->words[at + k]);
}

static void put_constant(struct work *w, uint32_t type, uint32_t id, uint32_t value) {
    const bool truth = kind_of(w, type) == BOOL;
    put(w, truth ? 3u << 16 | (value ? OP_CONSTANT_TRUE : OP_CONSTANT_FALSE) : 4u << 16 | OP_CONSTANT);
    put(w, type);
    put(w, id);
    if (!truth) put(w, value);
}

static void put_entry_point(struct work *w, uint32_t at) {
    const size_t start = w->out.count;
    const uint32_t end = at + length_at(w, at), names = name_end(w, at);
    for (uint32_t k = at; k < end; k++)
        if (k < names || (w->words[k] < w->bound && w->used[w->words[k]] == USED)) put(w, w->words[k]);
    w->out.words[start] = (uint32_t)(w->out.count - start) << 16 | OP_ENTRY_POINT;
}

static void put_global(struct work *w, uint32_t at) {
    const uint32_t op = op_at(w, at), *i = w->words + at, result = result_word(w, at);
    if (!w->traces && is_need_of_queries(w, at)) return;
    if (op == OP_ENTRY_POINT) put_entry_point(w, at);
    else if (is_annotation(op)) {
        if (i[1] >= w->bound || w->used[i[1]] != USED) return;
        const bool settled = op == OP_DECORATE && (is_folded(w, i[1]) || (i[2] == DECORATION_SPEC_ID && w->facts[i[1]].knowledge == VALUE));
        if (!settled) put_instruction(w, at);
    } else if (op == OP_TYPE_FORWARD_POINTER) {
        if (w->used[i[1]] == USED) put_instruction(w, at);
    } else if (!result) put_instruction(w, at);
    else if (w->used[i[result]] != USED && op != OP_EXT_INST_IMPORT) return;
    else if (between(op, OP_SPEC_CONSTANT_TRUE, OP_SPEC_CONSTANT_OP) && w->facts[i[2]].knowledge == VALUE)
        put_constant(w, i[1], i[2], w->facts[i[2]].value);
    else {
        put_instruction(w, at);
        if (op == OP_SPEC_CONSTANT_COMPOSITE) w->out.words[w->out.count - length_at(w, at)] -= OP_SPEC_CONSTANT_COMPOSITE - OP_CONSTANT_COMPOSITE;
    }
}

/* The continue target of this loop, if no way leads there, or 0. */
static uint32_t way_back_of(const struct work *w, const struct block *block) {
    if (!block->merge || op_at(w, block->merge) != OP_LOOP_MERGE) return 0;
    const uint32_t label = w->words[block->merge + 2];
    return find_block(w, label)->fate == WAY_BACK ? label : 0;
}

/* Instructions that have become constants. */
static void put_new_constants(struct work *w) {
    for (uint32_t b = 0; b < w->block_count; b++) {
        const struct block *block = &w->blocks[b];
        if (block->fate != KEPT) continue;
        for (uint32_t at = block->start; at < block->last; at += length_at(w, at)) {
            if (op_at(w, at) == OP_LABEL || !is_pure(w, at)) continue;
            const uint32_t type = w->words[at + 1], id = w->words[at + 2];
            if (w->used[id] == USED && is_folded(w, id)) put_constant(w, type, id, w->facts[id].value);
        }
    }
}

static void put_phi(struct work *w, const struct block *block, uint32_t at, uint32_t undefined) {
    const size_t start = w->out.count;
    const uint32_t *i = w->words + at, way_back = way_back_of(w, block);
    for (uint32_t k = 0; k < 3; k++) put(w, i[k]);
    for (uint32_t k = 3; k + 1 < i[0] >> 16; k += 2)
        if (leads_to(w, i[k + 1], block->label)) {
            put(w, i[k]);
            put(w, i[k + 1]);
        }
    if (way_back) {
        put(w, undefined);
        put(w, way_back);
    }
    w->out.words[start] = (uint32_t)(w->out.count - start) << 16 | OP_PHI;
}

static void put_last(struct work *w, const struct block *block) {
    const uint32_t *last = w->words + block->last, target = known_target(w, block);
    const bool is_switch = (last[0] & 0xffff) == OP_SWITCH;
    if (target && is_switch) { /* cases may be left from deep within: the construct stays */
        put(w, 3u << 16 | OP_SWITCH);
        put(w, last[1]);
        put(w, target);
    } else if (target) {
        put(w, 2u << 16 | OP_BRANCH);
        put(w, target);
    } else put_instruction(w, block->last);
}

static void put_block(struct work *w, const struct block *block, uint32_t *undefined) {
    put(w, 2u << 16 | OP_LABEL);
    put(w, block->label);
    if (block->fate == NO_WAY_OUT) put(w, 1u << 16 | OP_UNREACHABLE);
    if (block->fate == WAY_BACK) {
        put(w, 2u << 16 | OP_BRANCH);
        put(w, block->header);
    }
    if (block->fate != KEPT) return;
    const bool decided = known_target(w, block) && op_at(w, block->last) == OP_BRANCH_CONDITIONAL;
    for (uint32_t at = block->start + length_at(w, block->start); at < block->last; at += length_at(w, at)) {
        const uint32_t op = op_at(w, at), *i = w->words + at;
        if (op == OP_SELECTION_MERGE && decided) continue;
        if (is_pure(w, at) && (w->used[i[2]] != USED || is_folded(w, i[2]))) continue;
        if (op == OP_PHI) put_phi(w, block, at, way_back_of(w, block) ? (*undefined)++ : 0);
        else if (op == OP_SELECT && chosen_operand(w, at)) {
            put(w, 4u << 16 | OP_COPY_OBJECT);
            put(w, i[1]);
            put(w, i[2]);
            put(w, chosen_operand(w, at));
        } else put_instruction(w, at);
    }
    put_last(w, block);
}

/* Whether a phi stays whose loop has lost its second turn. */
static bool needs_undefined(const struct work *w, const struct block *block, uint32_t at) {
    return op_at(w, at) == OP_PHI && way_back_of(w, block) && w->used[w->words[at + 2]] == USED && !is_folded(w, w->words[at + 2]);
}

/* What the second turn would bring to such phis. */
static void put_undefined(struct work *w) {
    for (uint32_t b = 0; b < w->block_count; b++)
        for (uint32_t at = w->blocks[b].start; w->blocks[b].fate == KEPT && at < w->blocks[b].last; at += length_at(w, at))
            if (needs_undefined(w, &w->blocks[b], at)) {
                put(w, 3u << 16 | OP_UNDEF);
                put(w, w->words[at + 1]);
                put(w, w->next_id++);
            }
}

static void write_module(struct work *w) {
    for (uint32_t k = 0; k < HEADER_WORDS; k++) put(w, w->words[k]);
    for (uint32_t at = HEADER_WORDS; at < w->functions; at += length_at(w, at)) put_global(w, at);
    put_new_constants(w);
    uint32_t undefined = w->next_id;
    put_undefined(w);
    for (uint32_t at = w->functions, length; at < w->count; at += length) {
        length = length_at(w, at);
        if (op_at(w, at) != OP_LABEL) {
            put_instruction(w, at);
            continue;
        }
        const struct block *block = find_block(w, w->words[at + 1]);
        length = block->end - block->start;
        if (block->fate != DROPPED) put_block(w, block, &undefined);
    }
    w->out.words[3] = w->next_id;
}

/* ---- all of it ---- */

static size_t block_bytes(const struct work *w) {
    return w->bound * (4 * sizeof(uint32_t) + sizeof(struct fact) + sizeof(unsigned char)) + w->block_count * sizeof(struct block);
}

fnl_result gpu_specialise(const fnl_host *host, const uint32_t *words, size_t count, uint32_t constant_count,
                          const struct gpu_constant *constants, struct gpu_spirv *out) {
    *out = (struct gpu_spirv){0};
    if (count < HEADER_WORDS || count > UINT32_MAX / 8 || words[0] != MAGIC || words[3] > MOST_IDS) return FNL_ERROR_INVALID;
    struct work w = {.words = words, .count = (uint32_t)count, .bound = words[3], .constant_count = constant_count, .constants = constants};
    w.next_id = w.bound;
    if (!find_parts(&w, true)) return FNL_ERROR_INVALID;
    const size_t bytes = block_bytes(&w);
    char *memory = host_allocate_zero(host, bytes);
    /* Instructions become no longer, but for 3 words of OpUndef for a loop's phi of at least 7. */
    w.out.size = (count + count / 2) * sizeof *words;
    w.out.words = memory ? host_allocate(host, w.out.size) : NULL;
    if (!w.out.words) {
        if (memory) host_free(host, memory, bytes);
        return FNL_ERROR_MEMORY;
    }
    w.blocks = (struct block *)(void *)memory;
    w.facts = (struct fact *)(void *)(w.blocks + w.block_count);
    w.defined = (uint32_t *)(void *)(w.facts + w.bound);
    w.spec = w.defined + w.bound;
    w.blocks_of = w.spec + w.bound;
    w.line = w.blocks_of + w.bound;
    w.used = (unsigned char *)(w.line + w.bound);
    fnl_result result = find_parts(&w, false) ? FNL_OK : FNL_ERROR_INVALID;
    if (result == FNL_OK) {
        read_constants(&w);
        find_ways(&w);
        find_uses(&w);
        find_queries(&w);
        write_module(&w);
        *out = w.out;
    } else host_free(host, w.out.words, w.out.size);
    host_free(host, memory, bytes);
    return result;
}
