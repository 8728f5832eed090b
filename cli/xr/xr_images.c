/* SPDX-License-Identifier: MIT */
/* The images that the runtime shows: one for the views of one size, with a layer for each, and one for their depth. */
#include "xr/xr.h"

#include <stdio.h>
#include <string.h>

static bool offers(const int64_t *formats, uint32_t count, int64_t format) {
    for (uint32_t i = 0; i < count; i++)
        if (formats[i] == format) return true;
    return false;
}

/*
 * 8 bits in sRGB, which Fanal fills with the picture of `fanal render`; else half floats in linear light, without tone mapping. A runtime takes 8 bits
 * that are not called sRGB for linear light, so they are the last resort.
 */
static bool choose_formats(struct xr *x) {
    static const int64_t colors[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM};
    enum { COLORS = sizeof colors / sizeof *colors, MOST = 128 };
    int64_t formats[MOST];
    uint32_t count = 0;
    if (!xr_good(x, "xrEnumerateSwapchainFormats", xrEnumerateSwapchainFormats(x->session, 0, &count, NULL))) return false;
    if (count > MOST) count = MOST;
    if (!xr_good(x, "xrEnumerateSwapchainFormats", xrEnumerateSwapchainFormats(x->session, count, &count, formats))) return false;
    x->color_format = 0;
    for (uint32_t i = 0; i < COLORS && !x->color_format; i++)
        if (offers(formats, count, colors[i])) x->color_format = colors[i];
    if (!x->color_format) {
        fputs("fanal: error: the OpenXR runtime takes none of the image formats that Fanal writes: 8-bit RGBA or BGRA, or RGBA of half floats\n", stderr);
        x->end = XR_FAILED;
        return false;
    }
    if (x->color_format == VK_FORMAT_R8G8B8A8_UNORM || x->color_format == VK_FORMAT_B8G8R8A8_UNORM)
        fputs("fanal: warning: the OpenXR runtime has no sRGB images: the picture may look washed out\n", stderr);
    x->depth_format = x->has_depth && offers(formats, count, VK_FORMAT_D32_SFLOAT) ? VK_FORMAT_D32_SFLOAT : 0;
    if (x->has_depth && !x->depth_format && !x->options->quiet) fputs("fanal: warning: the OpenXR runtime takes no D32_SFLOAT: goes on without depth\n", stderr);
    return true;
}

static bool make_chain(struct xr *x, const struct xr_group *group, int64_t format, XrSwapchainUsageFlags usage, XrSwapchain *chain, XrSwapchainImageVulkan2KHR images[XR_IMAGES]) {
    const XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                        .usageFlags = XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | usage,
                                        .format = format,
                                        .sampleCount = 1,
                                        .width = group->width,
                                        .height = group->height,
                                        .faceCount = 1,
                                        .arraySize = group->count,
                                        .mipCount = 1};
    uint32_t count = 0;
    if (!xr_good(x, "xrCreateSwapchain", xrCreateSwapchain(x->session, &info, chain))) {
        *chain = XR_NULL_HANDLE;
        return false;
    }
    for (uint32_t i = 0; i < XR_IMAGES; i++) images[i] = (XrSwapchainImageVulkan2KHR){.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR};
    return xr_good(x, "xrEnumerateSwapchainImages", xrEnumerateSwapchainImages(*chain, XR_IMAGES, &count, (XrSwapchainImageBaseHeader *)images));
}

bool xr_make_images(struct xr *x) {
    if (!choose_formats(x)) return false;
    x->group_count = 0;
    for (uint32_t i = 0; i < x->view_count; i++) {
        const uint32_t width = x->configured[i].recommendedImageRectWidth, height = x->configured[i].recommendedImageRectHeight;
        struct xr_group *last = &x->groups[x->group_count - (x->group_count > 0)];
        if (x->group_count > 0 && last->width == width && last->height == height) {
            last->count++;
            continue;
        }
        x->groups[x->group_count++] = (struct xr_group){.first = i, .count = 1, .width = width, .height = height};
    }
    for (uint32_t i = 0; i < x->group_count; i++) {
        struct xr_group *group = &x->groups[i];
        if (!make_chain(x, group, x->color_format, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT, &group->color, group->colors)) return false;
        if (x->depth_format && !make_chain(x, group, x->depth_format, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, &group->depth, group->depths)) return false;
        if (fnl_renderer_create(x->device, x->scene, &group->renderer) != FNL_OK) {
            x->end = XR_FAILED;
            return false;
        }
    }
    return true;
}

void xr_free_images(struct xr *x) {
    for (uint32_t i = 0; i < x->group_count; i++) {
        if (x->groups[i].color) xr_note_end(x, "xrDestroySwapchain", xrDestroySwapchain(x->groups[i].color));
        if (x->groups[i].depth) xr_note_end(x, "xrDestroySwapchain", xrDestroySwapchain(x->groups[i].depth));
        x->groups[i].color = x->groups[i].depth = XR_NULL_HANDLE;
    }
}

static bool take_image(struct xr *x, XrSwapchain chain, const XrSwapchainImageVulkan2KHR *images, VkImage *out) {
    const XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, .timeout = 1000000000};
    uint32_t index = 0;
    XrResult result;
    if (!xr_good(x, "xrAcquireSwapchainImage", xrAcquireSwapchainImage(chain, NULL, &index))) return false;
    for (uint32_t tries = 0; (result = xrWaitSwapchainImage(chain, &wait)) == XR_TIMEOUT_EXPIRED && tries < 10;) tries++;
    if (result == XR_TIMEOUT_EXPIRED) {
        fputs("fanal: error: xrWaitSwapchainImage: the OpenXR runtime has not let go of an image for ten seconds\n", stderr);
        x->end = XR_FAILED;
        return false;
    }
    *out = images[index].image;
    return xr_good(x, "xrWaitSwapchainImage", result);
}

bool xr_take_images(struct xr *x, const struct xr_group *group, VkImage *color, VkImage *depth) {
    *depth = VK_NULL_HANDLE;
    return take_image(x, group->color, group->colors, color) && (!group->depth || take_image(x, group->depth, group->depths, depth));
}

bool xr_release_images(struct xr *x, const struct xr_group *group) {
    return xr_good(x, "xrReleaseSwapchainImage", xrReleaseSwapchainImage(group->color, NULL)) &&
           (!group->depth || xr_good(x, "xrReleaseSwapchainImage", xrReleaseSwapchainImage(group->depth, NULL)));
}

void xr_scaled_size(const struct xr *x, const struct xr_group *group, uint32_t *width, uint32_t *height) {
    *width = (uint32_t)fmaxf(1, roundf((float)group->width * x->scale));
    *height = (uint32_t)fmaxf(1, roundf((float)group->height * x->scale));
}
