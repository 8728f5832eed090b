/* SPDX-License-Identifier: MIT */
/* The controls of two methods, above the options. */
#include "view/view.h"

#include "view/ui.h"

#include <math.h>

static void show_numbers(const struct view_compare *c) {
    const fnl_image_difference *d = &c->numbers;
    if (!c->is_shown)
        ui_note("while something moves: split");
    else if (d->differing_pixels == 0)
        ui_text("A and B are equal");
    else
        ui_text("PSNR %.2f dB, at most %.1f/255 at %u, %u\n%llu of %llu pixels differ, SSIM %.5f", d->psnr, d->max * 255, d->max_x, d->max_y,
                (unsigned long long)d->differing_pixels, (unsigned long long)c->shown.width * c->shown.height, d->ssim);
}

void view_compare_choose(struct view *v) {
    struct view_compare *c = &v->compare;
    if (ui_radio("edit A", !c->edits_b)) c->edits_b = false;
    ui_same_line();
    if (ui_radio("edit B", c->edits_b)) c->edits_b = true;
    ui_tooltip("Which side's options the menus and panels edit");
    ui_same_line();
    if (ui_button("copy A to B")) view_compare_copy(v);
    ui_same_line();
    if (ui_button("swap")) view_compare_swap(v);
}

void view_panel_compare(struct view *v) {
    static const char *const help[VIEW_COMPARE_COUNT] = {"One picture", "A left of the line, B right of it; drag the line",
                                                         "Each in half of the window, rendered at that size", "The difference between the pictures, at rest"};
    struct view_compare *c = &v->compare;
    for (int i = 0; i < VIEW_COMPARE_COUNT; i++) {
        if (ui_radio(view_compare_name((enum view_compare_mode)i), i == (int)c->mode)) view_compare_begin(v, (enum view_compare_mode)i);
        ui_tooltip(help[i]);
    }
    if (c->mode == VIEW_COMPARE_OFF) return;
    ui_separator();
    view_compare_choose(v);
    if (c->mode == VIEW_COMPARE_DIFFERENCE) {
        ui_item_width(150);
        if (ui_number("gain", &c->gain, 0, 64, c->gain > 0 ? "%.3g" : "greatest is white")) view_want(v, 2);
        ui_tooltip("What the differences are multiplied by; 0: such that the greatest is white");
        show_numbers(c);
    }
}
