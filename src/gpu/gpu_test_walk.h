/* SPDX-License-Identifier: MIT */
// What C and GLSL both understand: branches of all kinds over two constants. A shader whose constants are known in advance must find what C finds.

WALK walk_early(uint mode, uint x) {
    if (mode == 3u) return x * 3u;
    if ((mode & 4u) != 0u) {
        if (x > 10u) return x - 10u;
        x += 100u;
    }
    return x + 1u;
}

WALK walk_switch(uint mode, uint x) {
    switch (mode) {
        case 0u:
        case 2u:
            if (x < 50u) {
                x += 7u;
                break;
            }
            x ^= 5u; /* fall through */
        case 1u: x *= 2u; break;
        case 5u: return 77u;
        default:
            if (x == 9u) break;
            x += mode;
    }
    return x;
}

WALK walk_loops(uint mode, uint turns, uint x) {
    for (uint i = 0u; i < turns; i++) {
        if (mode == 1u && i > 3u) break;
        if ((mode & 2u) != 0u && (x & 1u) != 0u) {
            x += i;
            continue;
        }
        x = walk_early(mode, x) + i;
        if (mode == 6u) break; /* always in the first turn */
    }
    do {
        x += 2u;
        if (mode == 7u) return x ^ turns;
    } while (mode != 0u && x < 40u);
    for (uint k = 0u; k < 5u; k++) {
        if (mode == 4u) return x + k;
        for (uint j = 0u; j < k; j++) {
            if (mode == 2u) break;
            if (x % 7u == j) x += turns / (mode + 1u);
        }
        x += k;
    }
    return x;
}

WALK walk(uint mode, uint turns, uint x) {
    bool odd = (mode & 1u) != 0u, both = odd && turns > 2u;
    uint y = both || mode == 2u ? walk_switch(mode, x) : walk_loops(mode, turns, x);
    if (!odd || (turns << 2) > 15u) y = walk_loops(mode ^ 1u, turns & 3u, y);
    if (turns == 0u) {
        for (;;) {
            y++;
            if (y % 3u == 0u || mode > 5u) break;
        }
    }
    return both ? y + 1u : walk_switch(mode ^ 2u, y);
}
