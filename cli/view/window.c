/* SPDX-License-Identifier: MIT */
/* The window, by GLFW. Places are in pixels of its picture, which may be finer than the screen's units. */
#include "view/view.h"

#include "print.h"

#include "fanal/vulkan.h"

#define GLFW_INCLUDE_NONE
#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include <stdlib.h>
#include <string.h>

struct view_window {
    GLFWwindow *handle;
    struct view_queue *queue;
    GLFWgamepadstate pad; /* as it was last asked for */
    bool captured;
};

_Static_assert((int)FNL_PRESENT_COUNT == (int)VIEW_PRESENT_COUNT && (int)FNL_COLOR_SPACE_COUNT == (int)VIEW_COLOR_COUNT, "view.h has these");

static struct view_queue *queue_of(GLFWwindow *handle) { return ((struct view_window *)glfwGetWindowUserPointer(handle))->queue; }
static void add(GLFWwindow *handle, struct view_event event) { view_queue_add(queue_of(handle), &event); }

static uint32_t modifiers_of(int mods) {
    return (mods & GLFW_MOD_SHIFT ? VIEW_SHIFT : 0u) | (mods & GLFW_MOD_CONTROL ? VIEW_CONTROL : 0u) | (mods & GLFW_MOD_ALT ? VIEW_ALT : 0u);
}

static void on_move(GLFWwindow *handle, double x, double y) {
    int width, height, pixels_across, pixels_down;
    glfwGetWindowSize(handle, &width, &height);
    glfwGetFramebufferSize(handle, &pixels_across, &pixels_down);
    const double across = width > 0 ? (double)pixels_across / width : 1, down = height > 0 ? (double)pixels_down / height : 1;
    add(handle, (struct view_event){.kind = VIEW_MOVE, .x = (float)(x * across), .y = (float)(y * down)});
}
static void on_button(GLFWwindow *handle, int button, int action, int mods) {
    add(handle, (struct view_event){.kind = VIEW_BUTTON, .code = button, .down = action == GLFW_PRESS, .modifiers = modifiers_of(mods)});
}
static void on_wheel(GLFWwindow *handle, double x, double y) { add(handle, (struct view_event){.kind = VIEW_WHEEL, .x = (float)x, .y = (float)y}); }
static void on_key(GLFWwindow *handle, int key, int scancode, int action, int mods) {
    (void)scancode;
    if (action == GLFW_REPEAT || key < 0 || key > 511) return;
    add(handle, (struct view_event){.kind = VIEW_KEY, .code = key, .down = action == GLFW_PRESS, .modifiers = modifiers_of(mods)});
}
static void on_character(GLFWwindow *handle, unsigned code) { add(handle, (struct view_event){.kind = VIEW_CHARACTER, .code = (int)code}); }
static void on_size(GLFWwindow *handle, int width, int height) {
    add(handle, (struct view_event){.kind = VIEW_SIZE, .x = (float)width, .y = (float)height});
}
static void on_drop(GLFWwindow *handle, int count, const char **paths) {
    struct view_event event = {.kind = VIEW_DROP};
    if (count < 1) return;
    snprintf(event.text, sizeof event.text, "%s", paths[0]);
    add(handle, event);
}
static void on_scale(GLFWwindow *handle, float x, float y) {
    (void)x;
    add(handle, (struct view_event){.kind = VIEW_SCALE, .x = y < 0.5f ? 0.5f : y > 4 ? 4 : y});
}
static void on_close(GLFWwindow *handle) { add(handle, (struct view_event){.kind = VIEW_CLOSE}); }
/* What was hidden is shown again. */
static void on_refresh(GLFWwindow *handle) {
    int width, height;
    glfwGetFramebufferSize(handle, &width, &height);
    on_size(handle, width, height);
}

bool view_window_create(uint32_t width, uint32_t height, const char *title, struct view_queue *queue, struct view_window **out) {
    const char *reason = NULL;
    struct view_window *window = calloc(1, sizeof *window);
    if (!window) return false;
    if (!glfwInit()) {
        glfwGetError(&reason);
        fprintf(stderr, "fanal: error: no window can be opened here: %s; --headless draws without one\n", reason ? reason : "GLFW does not start");
        free(window);
        return false;
    }
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    window->handle = glfwCreateWindow((int)width, (int)height, title, NULL, NULL);
    if (!window->handle) {
        glfwGetError(&reason);
        fprintf(stderr, "fanal: error: no window can be opened here: %s; --headless draws without one\n", reason ? reason : "for no reason that GLFW tells");
        glfwTerminate();
        free(window);
        return false;
    }
    window->queue = queue;
    glfwSetWindowUserPointer(window->handle, window);
    glfwSetCursorPosCallback(window->handle, on_move);
    glfwSetMouseButtonCallback(window->handle, on_button);
    glfwSetScrollCallback(window->handle, on_wheel);
    glfwSetKeyCallback(window->handle, on_key);
    glfwSetCharCallback(window->handle, on_character);
    glfwSetFramebufferSizeCallback(window->handle, on_size);
    glfwSetWindowRefreshCallback(window->handle, on_refresh);
    glfwSetWindowContentScaleCallback(window->handle, on_scale);
    glfwSetDropCallback(window->handle, on_drop);
    glfwSetWindowCloseCallback(window->handle, on_close);
    *out = window;
    return true;
}

void view_window_destroy(struct view_window **window) {
    if (!*window) return;
    glfwDestroyWindow((*window)->handle);
    glfwTerminate();
    free(*window);
    *window = NULL;
}

bool view_window_open_swapchain(struct view_window *window, fnl_device *device, uint32_t present, uint32_t color, fnl_swapchain **out) {
    fnl_vulkan_handles handles;
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    if (fnl_device_query_vulkan(device, &handles) != FNL_OK) return false;
    if (glfwCreateWindowSurface(handles.instance, window->handle, NULL, &surface) != VK_SUCCESS) {
        const char *reason = NULL;
        glfwGetError(&reason);
        fprintf(stderr, "fanal: error: the window cannot show pictures of Vulkan: %s\n", reason ? reason : "for no reason that GLFW tells");
        return false;
    }
    fnl_swapchain_params params = fnl_swapchain_params_default();
    view_window_query_size(window, &params.width, &params.height);
    params.present = (fnl_present)present;
    params.color = (fnl_color_space)color;
    return fnl_swapchain_create(device, surface, &params, out) == FNL_OK;
}

/* Sticks have no events: what has changed becomes one. Near their middle they count as at rest. */
static void poll_gamepad(struct view_window *window) {
    GLFWgamepadstate now = {0};
    int id = GLFW_JOYSTICK_1;
    while (id <= GLFW_JOYSTICK_LAST && !glfwJoystickIsGamepad(id)) id++;
    if (id <= GLFW_JOYSTICK_LAST && glfwGetWindowAttrib(window->handle, GLFW_FOCUSED)) glfwGetGamepadState(id, &now);
    for (int i = 0; i <= GLFW_GAMEPAD_AXIS_LAST; i++) {
        const bool trigger = i == GLFW_GAMEPAD_AXIS_LEFT_TRIGGER || i == GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER;
        float *axis = &now.axes[i];
        if (trigger && id <= GLFW_JOYSTICK_LAST) *axis = (*axis + 1) / 2;
        if (*axis > -0.15f && *axis < 0.15f) *axis = 0;
        if (*axis == window->pad.axes[i]) continue;
        add(window->handle, (struct view_event){.kind = VIEW_PAD, .code = i, .x = *axis > 1 ? 1 : *axis < -1 ? -1 : *axis});
    }
    for (int i = 0; i <= GLFW_GAMEPAD_BUTTON_LAST; i++)
        if (now.buttons[i] != window->pad.buttons[i]) add(window->handle, (struct view_event){.kind = VIEW_PAD_BUTTON, .code = i, .down = now.buttons[i] == GLFW_PRESS});
    window->pad = now;
}

bool view_window_has_gamepad(const struct view_window *window) {
    (void)window;
    for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; id++)
        if (glfwJoystickIsGamepad(id)) return true;
    return false;
}

void view_window_capture_mouse(struct view_window *window, bool captured) {
    if (window->captured != captured) glfwSetInputMode(window->handle, GLFW_CURSOR, captured ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    window->captured = captured;
}

void view_window_poll(struct view_window *window, double seconds) {
    poll_gamepad(window);
    if (window->queue->count > 0) seconds = 0;
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

void view_window_query_size(const struct view_window *window, uint32_t *width, uint32_t *height) {
    int across, down;
    glfwGetFramebufferSize(window->handle, &across, &down);
    *width = across > 0 ? (uint32_t)across : 0;
    *height = down > 0 ? (uint32_t)down : 0;
}

float view_window_scale(const struct view_window *window) {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window->handle, &x, &y);
    return y > 0 ? y : 1;
}

void view_window_set_clipboard(struct view_window *window, const char *text) { glfwSetClipboardString(window->handle, text); }
void view_window_set_title(struct view_window *window, const char *title) { glfwSetWindowTitle(window->handle, title); }
