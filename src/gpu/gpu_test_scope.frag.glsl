// SPDX-License-Identifier: MIT
#version 460

layout(constant_id = 0) const float scale = 1.0;
layout(input_attachment_index = 1, set = 1, binding = 1) uniform subpassInput below;
layout(location = 0) in vec4 color;
layout(location = 0) out vec4 target;

void main() { target = subpassLoad(below) * scale + color; }
