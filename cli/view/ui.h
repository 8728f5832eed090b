/* SPDX-License-Identifier: MIT */
/**
 * Widgets, by Dear ImGui behind C functions: what the panels need, no more. One user interface per process. Labels name widgets: what follows "##" is
 * not shown. Widgets return true when the user has just changed their value.
 */
#ifndef FNL_CLI_VIEW_UI_H
#define FNL_CLI_VIEW_UI_H

#include "fanal/overlay.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- life ---- */

/** False when memory ran out. `scale`: 1 for 96 dots an inch, 0.5 .. 4. */
bool ui_create(float scale, bool dark);
void ui_destroy(void);
/** Sizes of letters and gaps, and colours; outside of a frame. */
void ui_set_look(float scale, bool dark);

/* ---- input, outside of a frame; places in pixels of the window's picture ---- */

void ui_mouse_moved(float x, float y);
void ui_mouse_button(int button, bool down); /* 0 left, 1 right, 2 middle */
void ui_mouse_wheel(float x, float y);
/** A key by GLFW's number. */
void ui_key(int key, bool down);
void ui_modifiers(bool control, bool shift, bool alt);
void ui_character(uint32_t code_point);
/** Whether input belongs to a widget, as of the last frame. */
bool ui_wants_mouse(void);
bool ui_wants_keys(void);

/* ---- frames ---- */

void ui_begin(uint32_t width, uint32_t height, double seconds); /* since the last frame */
/** All that was drawn; lives until the next ui_begin. */
void ui_end(fnl_overlay *out);

/** What ui_back_image shows under this number, 1 .. FNL_OVERLAY_IMAGES_MAX - 1; RGBA8, lives until another is set. NULL: white. */
void ui_set_image(uint32_t index, const fnl_image *image, uint64_t version);

/** Has the next frame scroll to a widget; NULL: no longer. */
void ui_seek(const char *label);
/** A place inside of a widget that the last frame has shown, by its label; false: none is in sight. */
bool ui_find(const char *label, float *x, float *y);

/* ---- over the picture and below the panels, between the two; pixels, colours 0xrrggbbaa ---- */

void ui_line(float x0, float y0, float x1, float y1, uint32_t color, float width);
void ui_disc(float x, float y, float radius, uint32_t color);
void ui_triangle(float x0, float y0, float x1, float y1, float x2, float y2, uint32_t color);

/* ---- widgets, between the two ---- */

/** A rectangle, pixels at scale 1 from the window's upper left corner. */
struct ui_rectangle {
    float x, y, width, height;
};
/** The toolbar, along the top. Its widgets wrap; ui_toolbar_end returns its height, pixels at scale 1. */
void ui_toolbar(void);
float ui_toolbar_end(void);
/** In the toolbar: opens a menu; true while it is open, and then ui_menu_end. `on`: it is drawn as pressed. */
bool ui_menu(const char *label, bool on);
void ui_menu_end(void);
bool ui_menu_is_open(void); /* as of the last frame; outside of one */
bool ui_toolbar_button(const char *label, bool on);
/** A panel without a title that fills a rectangle. Always ui_window_end. */
void ui_dock(const char *name, struct ui_rectangle at);
/** The same without a frame around it, as high as its widgets, in the middle of a rectangle. Always ui_window_end. */
void ui_card(const char *name, struct ui_rectangle within, float width);
/** The same, above and left of a point. */
void ui_corner(const char *name, float right, float bottom, float width);
/** A dialog in the middle of the window, from where it can be moved; never larger than the window. Always ui_window_end; false: folded. */
bool ui_dialog(const char *title, bool *open, float width, float height);
void ui_window_end(void);
/** Tabs of a dock. `front`: this one is shown now. False: another is. Each that is true ends with ui_tab_end, all with ui_tabs_end. */
bool ui_tabs(const char *name);
bool ui_tab(const char *label, bool *open, bool front);
void ui_tab_end(void);
void ui_tabs_end(void);
/** A part of an overlay's image as a button, and its name below. */
bool ui_picture_button(const char *label, uint32_t image, float top, float bottom, float width, float height, bool chosen);
/** A part of a window, or a list, with a scroll bar of its own. Always ui_child_end. */
void ui_child(const char *name, float height);
void ui_child_end(void);
/** A list of `count` lines with a check box or text each, of which `shown` are in sight: those from *first up to *end are to be added. Always ui_list_end. */
void ui_list(const char *name, float shown, uint32_t count, uint32_t *first, uint32_t *end);
void ui_list_end(void);

void ui_text(const char *format, ...) __attribute__((format(printf, 1, 2)));
void ui_note(const char *format, ...) __attribute__((format(printf, 1, 2))); /* less loud, wraps */
void ui_warning(const char *format, ...) __attribute__((format(printf, 1, 2)));
void ui_align_text(void); /* of the text that follows, with buttons beside it */
void ui_key_color(uint32_t rgba, const char *text); /* a square of this color, 0xrrggbbaa, and what it means */
void ui_separator(void);
void ui_same_line(void);
/** As ui_same_line, if a button with this label still fits; else a new line. */
void ui_same_line_if_fits(const char *label);
void ui_item_width(float width); /* of the next widget, pixels at scale 1; negative: leaves that much to its right */
/** Colours from a low to a high value, with these under their ends; a square of one colour. */
void ui_ramp(const fnl_vec3 *colors, uint32_t count, const char *low, const char *high);
void ui_swatch(const fnl_vec3 *color);
/** Behind all panels, in pixels of the window's picture. */
void ui_back_image(uint32_t index, float x, float y, float width, float height);
/** Also behind them: a line from top to bottom; words on a dark ground, which end at `x` (left_of) or begin there. */
void ui_back_line(float x, float height);
void ui_back_label(float x, float y, bool left_of, const char *text);
/** Words on a ground of the theme's, over the picture and below the panels; `x`, `y`: its lower left corner. */
void ui_back_note(float x, float y, const char *text);
/** For the widget before: when the mouse rests on it. */
void ui_tooltip(const char *text);
bool ui_header(const char *label, bool open_first); /* folds what follows away: false */
bool ui_button(const char *label);
bool ui_checkbox(const char *label, bool *value);
bool ui_radio(const char *label, bool chosen); /* true when it was clicked */
bool ui_number(const char *label, float *value, float low, float high, const char *format); /* a slider where both are finite, else dragged */
bool ui_count(const char *label, uint32_t *value, uint32_t low, uint32_t high);
bool ui_color(const char *label, float rgb[3]);
void ui_focus(void); /* the next widget gets the keys */
bool ui_input(const char *label, char *text, size_t capacity); /* true when Enter was pressed */
bool ui_combo(const char *label, const char *shown); /* true: open; then ui_choice and ui_combo_end */
bool ui_choice(const char *label, bool chosen);
void ui_combo_end(void);
/** Until ui_enabled: cannot be used. */
void ui_disabled(void);
void ui_enabled(void);
void ui_plot(const char *label, const float *values, uint32_t count, uint32_t first, float most, float height);
void ui_bar(float part, const char *text);
bool ui_table(const char *name, int columns, float first); /* the part of the width that the first column has */
void ui_cell(void);
void ui_table_end(void);

/* ---- a canvas: shapes in a part of a window, which scrolls. Places are pixels at scale 1 from its upper left corner, colours 0xrrggbbaa ---- */

/** What is in sight of it, and where the mouse is. */
struct ui_canvas {
    float left, top, width, height, mouse_x, mouse_y;
    bool hovered;
};
/** `width` and `height` are of all of it; `shown`: how high it is in the window. Shapes until ui_canvas_end, which must always follow. */
void ui_canvas_begin(const char *name, float width, float height, float shown, struct ui_canvas *out);
void ui_canvas_end(void);
/** A filled rectangle; true: the mouse is in it. With a `label` (or NULL) it is a widget that ui_find finds. */
bool ui_canvas_rect(const char *label, float x, float y, float width, float height, uint32_t color);
void ui_canvas_line(float x0, float y0, float x1, float y1, uint32_t color);
/** As much of a line of text as fits into the width. */
void ui_canvas_text(float x, float y, float width, uint32_t color, const char *text);
/** The left button has just been pressed. */
bool ui_clicked(void);
/** Beside the mouse, at once. */
void ui_hint(const char *format, ...) __attribute__((format(printf, 1, 2)));
/** What is left of the window's width and height, pixels at scale 1. */
float ui_width_left(void);
float ui_height_left(void);

#ifdef __cplusplus
}
#endif
#endif
