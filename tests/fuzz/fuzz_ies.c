/* SPDX-License-Identifier: MIT */
/* Photometric files: whatever the bytes, an error, or a profile that is finite in every direction. */
#include "scene/ies.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct arena arena;
    struct light_profile profile;
    arena_init(&arena, &host, (size_t)64 << 10);
    if (ies_read(&host, &arena, "input", bytes, size, &profile) == FNL_OK) {
        if (!(profile.candela > 0) || !isfinite(profile.candela) || profile.rows == 0 || profile.columns == 0) abort();
        for (uint32_t i = 0; i < (profile.rows + 1) * profile.columns; i++)
            if (!(profile.values[i] >= 0 && profile.values[i] <= 1)) abort();
        for (int i = 0; i < 50; i++) {
            const double across = i * 0.13, down = i * 0.063, value = light_profile_at(&profile, sin(down) * cos(across), sin(down) * sin(across), cos(down));
            if (!(value >= 0 && value <= 1)) abort();
        }
    }
    arena_finish(&arena);
    return 0;
}
