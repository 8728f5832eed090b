// SPDX-License-Identifier: MIT
// Which instance a vertex belongs to, and with LAYERED which view it is drawn for: instances are repeated for each view, and so is the first one of a draw.
// Comes behind view.glsl and before what uses DRAWN_VIEW.
#ifndef LAYERED_GLSL
#define LAYERED_GLSL

#ifdef LAYERED
uint drawn_layer() { return layered.first + uint(gl_InstanceIndex) % layered.count; }
uint drawn_instance() { return uint(gl_InstanceIndex) / layered.count; }
#undef DRAWN_VIEW
#define DRAWN_VIEW(first) view_at(first, drawn_layer())
#else
uint drawn_instance() { return uint(gl_InstanceIndex); }
#endif

#endif
