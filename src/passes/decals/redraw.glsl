// SPDX-License-Identifier: MIT
// What both stages of redrawn decals share.
#include "passes/decals/decals_redraw_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_redraw_push push; };
