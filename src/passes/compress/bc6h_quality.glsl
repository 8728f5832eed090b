// SPDX-License-Identifier: MIT
// What BC6H's quality mode does beyond mode 11; includes nothing, is included by bc6h.glsl. src/image/bc6h_encode.c has the same on the CPU:
// each operation on floats stands there as it stands here.

// Ends of lines in codes: from a0 to b0 in region 0, from a1 to b1 in region 1.
struct bc6h_lines {
    vec3 a0, b0, a1, b1;
};

// The best block so far: whole endpoints, w x y z, and an index in each four bits.
struct bc6h_best {
    float error;
    uint mode;
    uint pattern;
    ivec3 w, x, y, z;
    uvec2 indices;
};

const uint pattern_pairs[16] = uint[16](0x8888ccccu, 0xecc8eeeeu, 0xfeecc880u, 0xec80fec8u, 0xffecc800u, 0xe800fe80u, 0xff00ffe8u, 0xf000fff0u, 0x008ef710u, 0x08ce7100u, 0x7310008cu, 0x8cce3100u, 0x3110088cu, 0x366c6666u, 0x0ff017e8u, 0x399c718eu);
uint pattern_mask(uint pattern) { return pattern_pairs[pattern >> 1] >> (pattern & 1u) * 16u & 0xffffu; }
uint pattern_anchor(uint pattern) { return (0xcd1a0000u >> pattern & 1u) != 0u ? 2u : (0x32640000u >> pattern & 1u) != 0u ? 8u : 15u; }

ivec3 unquantise(ivec3 q, uint bits) {
    if (SIGNED) {
        ivec3 m = abs(q), most = ivec3((1 << (bits - 1u)) - 1);
        ivec3 middle = ((m << 15) + 0x4000) >> (bits - 1u);
        ivec3 v = mix(middle, ivec3(0x7fff), greaterThanEqual(m, most));
        v = mix(v, ivec3(0), equal(m, ivec3(0)));
        return bits >= 16u ? q : v * sign(q);
    }
    ivec3 v = ((q << 16) + 0x8000) >> bits;
    v = mix(v, ivec3(0xffff), equal(q, ivec3((1 << bits) - 1)));
    v = mix(v, ivec3(0), equal(q, ivec3(0)));
    return bits >= 15u ? q : v;
}

ivec3 finish(ivec3 v) { return SIGNED ? (abs(v) * 31 >> 5) * sign(v) : v * 31 >> 6; }

float inverse_length2(vec3 d) {
    precise float length2 = dot3(d, d);
    return length2 > 0.0 ? 1.0 / length2 : 0.0;
}

bool in_second(uint mask, int i) { return (mask >> uint(i) & 1u) != 0u; }

uint index_of(vec3 code, uint mask, int i, bc6h_lines l, vec3 d0, vec3 d1, float per0, float per1, bool two) {
    bool second = two && in_second(mask, i);
    precise vec3 from = code - (second ? l.a1 : l.a0);
    precise float t = dot3(from, second ? d1 : d0) * (second ? per1 : per0);
    precise float index = two ? t * INDEX3_SCALE + INDEX3_OFFSET : t * INDEX4_SCALE + INDEX4_OFFSET;
    return uint(clamp(index, 0.0, two ? 7.0 : 15.0));
}

void set_index(inout uvec2 indices, int i, uint index) {
    if (i < 8)
        indices.x |= index << (4 * i);
    else
        indices.y |= index << (4 * (i - 8));
}
uint get_index(uvec2 indices, int i) { return (i < 8 ? indices.x >> (4 * i) : indices.y >> (4 * (i - 8))) & 15u; }

int weight_of(uint index, bool two) { return int(two ? (index * 585u + 32u) >> 6 : (index * 273u + 32u) >> 6); }

uvec2 project(vec3 codes[16], bc6h_lines l, uint mask, bool two) {
    precise vec3 d0 = l.b0 - l.a0, d1 = l.b1 - l.a1;
    float per0 = inverse_length2(d0), per1 = two ? inverse_length2(d1) : 0.0;
    uvec2 indices = uvec2(0u);
    [[unroll]] for (int i = 0; i < 16; i++) set_index(indices, i, index_of(codes[i], mask, i, l, d0, d1, per0, per1, two));
    return indices;
}

float error_of(vec3 codes[16], uvec2 indices, ivec3 w, ivec3 x, ivec3 y, ivec3 z, uint bits, uint mask, bool two) {
    ivec3 u0 = unquantise(w, bits), v0 = unquantise(x, bits), u1 = two ? unquantise(y, bits) : ivec3(0), v1 = two ? unquantise(z, bits) : ivec3(0);
    precise float error = 0.0;
    [[unroll]] for (int i = 0; i < 16; i++) {
        bool second = two && in_second(mask, i);
        int weight = weight_of(get_index(indices, i), two);
        ivec3 code = finish(((second ? u1 : u0) * (64 - weight) + (second ? v1 : v0) * weight + 32) >> 6);
        precise vec3 off = codes[i] - vec3(code);
        error = error + dot3(off, off);
    }
    return error;
}

// Quantises the lines in a mode and keeps the block if it is better than the best; false if differences are too large whichever end comes first.
bool try_mode(inout bc6h_best best, vec3 codes[16], bc6h_lines l, uint mode, uint bits, uint delta, uint pattern, bool two) {
    ivec3 w = quantise(ivec3(l.a0), bits), x = quantise(ivec3(l.b0), bits), y = w, z = x;
    if (two) {
        y = quantise(ivec3(l.a1), bits);
        z = quantise(ivec3(l.b1), bits);
    }
    ivec3 spread = max(max(w, x), max(y, z)) - min(min(w, x), min(y, z));
    if (delta > 0u && any(greaterThanEqual(spread, ivec3(1 << (delta - 1u))))) return false;
    bc6h_lines decoded;
    decoded.a0 = vec3(finish(unquantise(w, bits)));
    decoded.b0 = vec3(finish(unquantise(x, bits)));
    decoded.a1 = two ? vec3(finish(unquantise(y, bits))) : vec3(0.0);
    decoded.b1 = two ? vec3(finish(unquantise(z, bits))) : vec3(0.0);
    uint mask = two ? pattern_mask(pattern) : 0u;
    uvec2 indices = project(codes, decoded, mask, two);
    float error = error_of(codes, indices, w, x, y, z, bits, mask, two);
    if (error < best.error) best = bc6h_best(error, mode, pattern, w, x, y, z, indices);
    return true;
}

// The most precise of the modes of one region that has room for the line; the same of two regions.
void try_one(inout bc6h_best best, vec3 codes[16], bc6h_lines l) {
    for (uint k = 0u; k < 4u; k++) {
        uint bits = k == 0u ? 16u : k == 1u ? 12u : k == 2u ? 11u : 10u;
        if (try_mode(best, codes, l, 14u - k, bits, k == 3u ? 0u : 20u - bits, 0u, false)) return;
    }
}
void try_two(inout bc6h_best best, vec3 codes[16], bc6h_lines l, uint pattern) {
    for (uint k = 0u; k < 3u; k++)
        if (try_mode(best, codes, l, k == 0u ? 6u : k == 1u ? 2u : 10u, k == 0u ? 9u : k == 1u ? 7u : 6u, k == 0u ? 5u : k == 1u ? 6u : 0u, pattern, true))
            return;
}

// Moves the ends of a line to where the squared error is least with these indices; indices that say nothing of the ends leave them.
void fit(vec3 codes[16], uvec2 indices, uint mask, bool two, bool region, inout vec3 first, inout vec3 last) {
    precise float a = 0.0, b = 0.0, c = 0.0;
    precise vec3 x = vec3(0.0), y = vec3(0.0);
    [[unroll]] for (int i = 0; i < 16; i++) {
        float inside = !two || in_second(mask, i) == region ? 1.0 : 0.0;
        precise float t = float(weight_of(get_index(indices, i), two)) * 0.015625;
        precise float u = 1.0 - t;
        a = a + inside * (u * u);
        b = b + inside * (u * t);
        c = c + inside * (t * t);
        precise vec3 from = codes[i] - first;
        x = x + inside * (u * from);
        y = y + inside * (t * from);
    }
    precise float determinant = a * c - b * b;
    if (!(determinant > 0.01)) return;
    float per = 1.0 / determinant, least = SIGNED ? -31743.0 : 0.0;
    precise vec3 base = first;
    precise vec3 from = ((c * x - b * y) * per + base) + 0.5;
    precise vec3 to = ((a * y - b * x) * per + base) + 0.5;
    first = clamp(floor(from), least, 31743.0);
    last = clamp(floor(to), least, 31743.0);
}

float component(vec3 v, uint c) { return c == 0u ? v.x : c == 1u ? v.y : v.z; }
uint longest_side(vec3 size) {
    uint c = size.y > size.x ? 1u : 0u;
    return size.z > component(size, c) ? 2u : c;
}

// The boxes of the regions, and of their diagonals those along which the codes lie: channels that fall where the longest one rises change their ends.
bc6h_lines bound_regions(vec3 codes[16], uint mask) {
    bc6h_lines l = bc6h_lines(vec3(1e9), vec3(-1e9), vec3(1e9), vec3(-1e9));
    [[unroll]] for (int i = 0; i < 16; i++) {
        bool second = in_second(mask, i);
        vec3 low = second ? l.a1 : l.a0, high = second ? l.b1 : l.b0;
        low = min(low, codes[i]);
        high = max(high, codes[i]);
        l.a0 = second ? l.a0 : low;
        l.b0 = second ? l.b0 : high;
        l.a1 = second ? low : l.a1;
        l.b1 = second ? high : l.b1;
    }
    uint longest0 = longest_side(l.b0 - l.a0), longest1 = longest_side(l.b1 - l.a1);
    precise vec3 middle0 = (l.a0 + l.b0) * 0.5, middle1 = (l.a1 + l.b1) * 0.5, covariance0 = vec3(0.0), covariance1 = vec3(0.0);
    [[unroll]] for (int i = 0; i < 16; i++) {
        bool second = in_second(mask, i);
        precise vec3 off = codes[i] - (second ? middle1 : middle0);
        precise vec3 sum = (second ? covariance1 : covariance0) + off * component(off, second ? longest1 : longest0);
        covariance0 = second ? covariance0 : sum;
        covariance1 = second ? sum : covariance1;
    }
    vec3 first0 = l.a0, first1 = l.a1;
    bvec3 turn0 = lessThan(covariance0, vec3(0.0)), turn1 = lessThan(covariance1, vec3(0.0));
    l.a0 = mix(l.a0, l.b0, turn0);
    l.b0 = mix(l.b0, first0, turn0);
    l.a1 = mix(l.a1, l.b1, turn1);
    l.b1 = mix(l.b1, first1, turn1);
    return l;
}

// These diagonals, fitted twice to the codes.
bc6h_lines fit_regions(vec3 codes[16], uint mask, bool two) {
    bc6h_lines l = bound_regions(codes, mask);
    [[dont_unroll]] for (uint turn = 0u; turn < 2u; turn++) {
        uvec2 indices = project(codes, l, mask, two);
        fit(codes, indices, mask, two, false, l.a0, l.b0);
        if (two) fit(codes, indices, mask, two, true, l.a1, l.b1);
    }
    return l;
}

// Sum of squared distances of the codes to the diagonals of their regions' boxes.
float distance_to_lines(vec3 codes[16], bc6h_lines l, uint mask) {
    precise vec3 d0 = l.b0 - l.a0, d1 = l.b1 - l.a1;
    float per0 = inverse_length2(d0), per1 = inverse_length2(d1);
    precise float sum = 0.0;
    [[unroll]] for (int i = 0; i < 16; i++) {
        bool second = in_second(mask, i);
        precise vec3 from = codes[i] - (second ? l.a1 : l.a0);
        precise float along = dot3(from, second ? d1 : d0);
        sum = sum + (dot3(from, from) - (along * along) * (second ? per1 : per0));
    }
    return sum;
}

uint choose_pattern(vec3 codes[16]) {
    uint best = 0u;
    float least = 3e38;
    [[dont_unroll]] for (uint pattern = 0u; pattern < 32u; pattern++) {
        uint mask = pattern_mask(pattern);
        float off = distance_to_lines(codes, bound_regions(codes, mask), mask);
        if (off < least) {
            least = off;
            best = pattern;
        }
    }
    return best;
}

// Bits `count` from `at` on, which is known when the shader is compiled.
void put(inout uvec4 block, int value, uint count, uint at) {
    uint bits = uint(value) & ((1u << count) - 1u), word = at >> 5, shift = at & 31u;
    block[word] |= bits << shift;
    if (shift + count > 32u) block[word + 1u] |= bits >> (32u - shift);
}

uvec4 pack_two(bc6h_best b) {
    uint mask = pattern_mask(b.pattern), anchor = pattern_anchor(b.pattern);
    bool turn0 = (b.indices.x & 15u) > 3u, turn1 = ((anchor < 8u ? b.indices.x >> (4u * anchor) : b.indices.y >> (4u * (anchor - 8u))) & 15u) > 3u;
    ivec3 e0 = turn0 ? b.x : b.w, e1 = turn0 ? b.w : b.x, e2 = turn1 ? b.z : b.y, e3 = turn1 ? b.y : b.z;
    if (b.mode != 10u) {
        e1 -= e0;
        e2 -= e0;
        e3 -= e0;
    }
    uvec4 block = uvec4(0u);
    if (b.mode == 6u) {
        put(block, 0x0e, 5u, 0u);
        put(block, e0.x, 9u, 5u);
        put(block, e2.z >> 4, 1u, 14u);
        put(block, e0.y, 9u, 15u);
        put(block, e2.y >> 4, 1u, 24u);
        put(block, e0.z, 9u, 25u);
        put(block, e3.z >> 4, 1u, 34u);
        put(block, e1.x, 5u, 35u);
        put(block, e3.y >> 4, 1u, 40u);
        put(block, e2.y, 4u, 41u);
        put(block, e1.y, 5u, 45u);
        put(block, e3.z, 1u, 50u);
        put(block, e3.y, 4u, 51u);
        put(block, e1.z, 5u, 55u);
        put(block, e3.z >> 1, 1u, 60u);
        put(block, e2.z, 4u, 61u);
        put(block, e2.x, 5u, 65u);
        put(block, e3.z >> 2, 1u, 70u);
        put(block, e3.x, 5u, 71u);
        put(block, e3.z >> 3, 1u, 76u);
    } else if (b.mode == 2u) {
        put(block, 0x01, 2u, 0u);
        put(block, e2.y >> 5, 1u, 2u);
        put(block, e3.y >> 4, 1u, 3u);
        put(block, e3.y >> 5, 1u, 4u);
        put(block, e0.x, 7u, 5u);
        put(block, e3.z, 1u, 12u);
        put(block, e3.z >> 1, 1u, 13u);
        put(block, e2.z >> 4, 1u, 14u);
        put(block, e0.y, 7u, 15u);
        put(block, e2.z >> 5, 1u, 22u);
        put(block, e3.z >> 2, 1u, 23u);
        put(block, e2.y >> 4, 1u, 24u);
        put(block, e0.z, 7u, 25u);
        put(block, e3.z >> 3, 1u, 32u);
        put(block, e3.z >> 5, 1u, 33u);
        put(block, e3.z >> 4, 1u, 34u);
        put(block, e1.x, 6u, 35u);
        put(block, e2.y, 4u, 41u);
        put(block, e1.y, 6u, 45u);
        put(block, e3.y, 4u, 51u);
        put(block, e1.z, 6u, 55u);
        put(block, e2.z, 4u, 61u);
        put(block, e2.x, 6u, 65u);
        put(block, e3.x, 6u, 71u);
    } else {
        put(block, 0x1e, 5u, 0u);
        put(block, e0.x, 6u, 5u);
        put(block, e3.y >> 4, 1u, 11u);
        put(block, e3.z, 1u, 12u);
        put(block, e3.z >> 1, 1u, 13u);
        put(block, e2.z >> 4, 1u, 14u);
        put(block, e0.y, 6u, 15u);
        put(block, e2.y >> 5, 1u, 21u);
        put(block, e2.z >> 5, 1u, 22u);
        put(block, e3.z >> 2, 1u, 23u);
        put(block, e2.y >> 4, 1u, 24u);
        put(block, e0.z, 6u, 25u);
        put(block, e3.y >> 5, 1u, 31u);
        put(block, e3.z >> 3, 1u, 32u);
        put(block, e3.z >> 5, 1u, 33u);
        put(block, e3.z >> 4, 1u, 34u);
        put(block, e1.x, 6u, 35u);
        put(block, e2.y, 4u, 41u);
        put(block, e1.y, 6u, 45u);
        put(block, e3.y, 4u, 51u);
        put(block, e1.z, 6u, 55u);
        put(block, e2.z, 4u, 61u);
        put(block, e2.x, 6u, 65u);
        put(block, e3.x, 6u, 71u);
    }
    put(block, int(b.pattern), 5u, 77u);
    uint low = 0u, high = 0u, at = 0u; // the 46 bits of indices, from bit 82 on
    [[unroll]] for (int i = 0; i < 16; i++) {
        uint index = get_index(b.indices, i);
        index = (in_second(mask, i) ? turn1 : turn0) ? 7u - index : index;
        if (at < 32u) {
            low |= index << at;
            if (at > 29u) high |= index >> (32u - at);
        } else {
            high |= index << (at - 32u);
        }
        at += i == 0 || uint(i) == anchor ? 2u : 3u;
    }
    block.z |= low << 18;
    block.w = low >> 14 | high << 18;
    return block;
}
