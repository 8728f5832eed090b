// SPDX-License-Identifier: MIT
#include "view/ui.h"

#include <imgui.h>

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

// Arrays that outlive a frame, of C's memory: this file must not need the C++ library.
template <typename T> struct growing {
    T *data = nullptr;
    size_t count = 0, capacity = 0;
    T *add(size_t more) {
        if (count + more > capacity) {
            size_t wanted = (count + more) * 2;
            T *moved = static_cast<T *>(realloc(static_cast<void *>(data), wanted * sizeof(T)));
            if (!moved) return nullptr;
            data = moved;
            capacity = wanted;
        }
        count += more;
        return data + count - more;
    }
    void finish() {
        free(data);
        *this = growing<T>();
    }
};

struct place {
    ImGuiID label;
    ImVec2 inside;
};

static struct {
    growing<place> places; // of the widgets of this frame
    growing<fnl_overlay_vertex> vertices;
    growing<uint32_t> indices;
    growing<fnl_overlay_draw> draws;
    fnl_image font;
    fnl_overlay_image images[FNL_OVERLAY_IMAGES_MAX]; // the first is the font
    uint64_t font_version;
    float scale;
    ImGuiID sought;
    bool dark;
    bool relaid;          // the window has another size than in the last frame, or letters have
    bool relooked;        // letters have another size than in the last frame
    float toolbar_height; // pixels
    float menu_width;     // of the menu that is open, pixels
    bool menu_was_open;   // when the button went down
} ui;

static_assert(sizeof(fnl_overlay_vertex) == sizeof(ImDrawVert), "vertices are copied as they are");

// ---- life ----

static void make_font() {
    ImGuiIO &io = ImGui::GetIO();
    io.Fonts->Clear();
    // Latin with accents, Greek, Cyrillic, and signs.
    static const ImWchar ranges[] = {0x20, 0x24f, 0x370, 0x52f, 0x2010, 0x2027, 0x20ac, 0x20ac, 0x2190, 0x21ff, 0x25a0, 0x25ff, 0};
    static const char *const files[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                        "/usr/share/fonts/TTF/DejaVuSans.ttf", "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};
    ImFont *font = nullptr;
    for (size_t i = 0; i < sizeof files / sizeof *files && !font; i++) {
        FILE *file = fopen(files[i], "rb");
        if (!file) continue;
        fclose(file);
        font = io.Fonts->AddFontFromFileTTF(files[i], std::floor(14 * ui.scale), nullptr, ranges);
    }
    if (!font) { // coarse, and without accents
        ImFontConfig config;
        config.SizePixels = std::floor(13 * ui.scale);
        io.Fonts->AddFontDefault(&config);
    }
    unsigned char *pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    ui.font = fnl_image();
    ui.font.width = static_cast<uint32_t>(width);
    ui.font.height = static_cast<uint32_t>(height);
    ui.font.format = FNL_PIXEL_FORMAT_RGBA8;
    ui.font.pixels = pixels;
    ui.font_version++;
}

void ui_set_look(float scale, bool dark) {
    ImGui::GetStyle() = ImGuiStyle();
    ui.dark = dark;
    if (dark)
        ImGui::StyleColorsDark();
    else
        ImGui::StyleColorsLight();
    ImGuiStyle &style = ImGui::GetStyle();
    style.WindowRounding = style.FrameRounding = style.GrabRounding = 3;
    style.Colors[ImGuiCol_PlotHistogram] = dark ? ImVec4(0.16f, 0.42f, 0.7f, 1) : ImVec4(0.55f, 0.76f, 0.96f, 1); // words are on it
    style.Colors[ImGuiCol_PlotLines] = style.Colors[ImGuiCol_Text];
    style.Colors[ImGuiCol_TextDisabled] = dark ? ImVec4(0.65f, 0.65f, 0.65f, 1) : ImVec4(0.35f, 0.35f, 0.35f, 1);
    if (!dark) style.Colors[ImGuiCol_PopupBg] = style.Colors[ImGuiCol_WindowBg]; // fields are white
    style.Colors[ImGuiCol_WindowBg].w = style.Colors[ImGuiCol_PopupBg].w = 1;
    style.ScaleAllSizes(scale);
    if (scale == ui.scale) return;
    ui.scale = scale;
    ui.relooked = true;
    make_font();
}

enum { ENTER = 257, KEYPAD_ENTER = 335 };
// Keys that widgets know, by GLFW's numbers.
static const struct {
    int number, key;
} keys[] = {{258, ImGuiKey_Tab},       {263, ImGuiKey_LeftArrow}, {262, ImGuiKey_RightArrow}, {265, ImGuiKey_UpArrow}, {264, ImGuiKey_DownArrow},
            {266, ImGuiKey_PageUp},    {267, ImGuiKey_PageDown},  {268, ImGuiKey_Home},       {269, ImGuiKey_End},     {260, ImGuiKey_Insert},
            {261, ImGuiKey_Delete},    {259, ImGuiKey_Backspace}, {32, ImGuiKey_Space},       {ENTER, ImGuiKey_Enter},   {256, ImGuiKey_Escape},
            {KEYPAD_ENTER, ImGuiKey_Enter},     {'A', ImGuiKey_A},         {'C', ImGuiKey_C},          {'V', ImGuiKey_V},       {'X', ImGuiKey_X},
            {'Y', ImGuiKey_Y},         {'Z', ImGuiKey_Z}};

bool ui_create(float scale, bool dark) {
    if (!ImGui::CreateContext()) return false;
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr; // the program remembers what is worth it
    io.LogFilename = nullptr;
    io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    io.ConfigWindowsMoveFromTitleBarOnly = true;
#if IMGUI_VERSION_NUM < 18700
    for (const auto &k : keys)
        if (k.number != KEYPAD_ENTER) io.KeyMap[k.key] = k.number; // one number for each
#endif
    ui_set_look(scale, dark);
    return true;
}

void ui_destroy(void) {
    ui.places.finish();
    ui.vertices.finish();
    ui.indices.finish();
    ui.draws.finish();
    if (ImGui::GetCurrentContext()) ImGui::DestroyContext();
    ui.scale = 0;
}

// ---- input ----

void ui_mouse_moved(float x, float y) {
#if IMGUI_VERSION_NUM >= 18700
    ImGui::GetIO().AddMousePosEvent(x, y);
#else
    ImGui::GetIO().MousePos = ImVec2(x, y);
#endif
}

void ui_mouse_button(int button, bool down) {
    if (button < 0 || button > 2) return;
#if IMGUI_VERSION_NUM >= 18700
    ImGui::GetIO().AddMouseButtonEvent(button, down);
#else
    ImGui::GetIO().MouseDown[button] = down;
#endif
}

void ui_mouse_wheel(float x, float y) {
#if IMGUI_VERSION_NUM >= 18700
    ImGui::GetIO().AddMouseWheelEvent(x, y);
#else
    ImGui::GetIO().MouseWheelH += x;
    ImGui::GetIO().MouseWheel += y;
#endif
}

void ui_key(int key, bool down) {
#if IMGUI_VERSION_NUM >= 18700
    for (const auto &k : keys)
        if (k.number == key) ImGui::GetIO().AddKeyEvent(static_cast<ImGuiKey>(k.key), down);
#else
    if (key == KEYPAD_ENTER) key = ENTER;
    if (key >= 0 && key < 512) ImGui::GetIO().KeysDown[key] = down;
#endif
}

void ui_modifiers(bool control, bool shift, bool alt) {
    ImGuiIO &io = ImGui::GetIO();
#if IMGUI_VERSION_NUM >= 18700
    io.AddKeyEvent(ImGuiMod_Ctrl, control);
    io.AddKeyEvent(ImGuiMod_Shift, shift);
    io.AddKeyEvent(ImGuiMod_Alt, alt);
#else
    io.KeyCtrl = control;
    io.KeyShift = shift;
    io.KeyAlt = alt;
#endif
}

void ui_character(uint32_t code_point) { ImGui::GetIO().AddInputCharacter(code_point); }
bool ui_wants_mouse(void) { return ImGui::GetIO().WantCaptureMouse; }
bool ui_wants_keys(void) { return ImGui::GetIO().WantTextInput; }

// ---- images: an ImTextureID is the number of one; it is a pointer in older versions of Dear ImGui and an integer in newer ones ----

static uint32_t image_of(ImTextureID id) {
    uint64_t number = 0;
    static_assert(sizeof id <= sizeof number, "texture ids");
    memcpy(&number, &id, sizeof id);
    return static_cast<uint32_t>(number);
}
static ImTextureID id_of(uint32_t image) {
    const uint64_t number = image;
    ImTextureID id;
    memcpy(&id, &number, sizeof id);
    return id;
}

void ui_set_image(uint32_t index, const fnl_image *image, uint64_t version) { ui.images[index] = {image, version}; }
void ui_back_image(uint32_t index, float x, float y, float width, float height) {
    ImGui::GetBackgroundDrawList()->AddImage(id_of(index), ImVec2(x, y), ImVec2(x + width, y + height));
}

static ImU32 color_of(const fnl_vec3 &c) { return ImGui::ColorConvertFloat4ToU32(ImVec4(c.x, c.y, c.z, 1)); }

void ui_ramp(const fnl_vec3 *colors, uint32_t count, const char *low, const char *high) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, height = 14 * ui.scale, step = width / static_cast<float>(count - 1);
    for (uint32_t i = 0; i + 1 < count; i++) {
        const ImU32 left = color_of(colors[i]), right = color_of(colors[i + 1]);
        const float x = corner.x + step * static_cast<float>(i);
        ImGui::GetWindowDrawList()->AddRectFilledMultiColor(ImVec2(x, corner.y), ImVec2(x + step, corner.y + height), left, right, right, left);
    }
    ImGui::Dummy(ImVec2(width, height));
    ImGui::TextUnformatted(low);
    ImGui::SameLine(std::fmax(0, width + ImGui::GetStyle().WindowPadding.x - ImGui::CalcTextSize(high).x));
    ImGui::TextUnformatted(high);
}
void ui_swatch(const fnl_vec3 *color) {
    const float side = ImGui::GetTextLineHeight();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(corner, ImVec2(corner.x + side, corner.y + side), color_of(*color));
    ImGui::Dummy(ImVec2(side, side));
}

void ui_back_line(float x, float height) {
    const float half = std::fmax(1, std::floor(ui.scale));
    ImGui::GetBackgroundDrawList()->AddRectFilled(ImVec2(x - half, 0), ImVec2(x + half, height), IM_COL32(255, 255, 255, 220));
}
void ui_back_note(float x, float y, const char *text) {
    const ImVec2 size = ImGui::CalcTextSize(text);
    const float gap = 6 * ui.scale;
    ImDrawList *list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(x, y - size.y - 2 * gap), ImVec2(x + size.x + 2 * gap, y), ImGui::GetColorU32(ImGuiCol_WindowBg, 0.85f), 3 * ui.scale);
    list->AddText(ImVec2(std::floor(x + gap), std::floor(y - size.y - gap)), ImGui::GetColorU32(ImGuiCol_Text), text);
}
void ui_back_label(float x, float y, bool left_of, const char *text) {
    const ImVec2 size = ImGui::CalcTextSize(text);
    const float gap = 4 * ui.scale, left = std::floor(left_of ? x - size.x - gap : x + gap);
    ImDrawList *list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(left - gap, y), ImVec2(left + size.x + gap, y + size.y + gap), IM_COL32(20, 20, 24, 200), 3 * ui.scale);
    list->AddText(ImVec2(left, y + gap / 2), IM_COL32(255, 255, 255, 255), text);
}

// ---- frames ----

void ui_begin(uint32_t width, uint32_t height, double seconds) {
    ImGuiIO &io = ImGui::GetIO();
    const ImVec2 size(static_cast<float>(width), static_cast<float>(height));
    ui.relaid = ui.relooked || size.x != io.DisplaySize.x || size.y != io.DisplaySize.y;
    ui.relooked = false;
    io.DisplaySize = size;
    io.DeltaTime = static_cast<float>(seconds > 1e-4 ? seconds : 1e-4);
    ImGui::NewFrame();
    ui.places.count = 0;
}

void ui_end(fnl_overlay *out) {
    ImGui::Render();
    const ImDrawData *data = ImGui::GetDrawData();
    ui.vertices.count = ui.indices.count = ui.draws.count = 0;
    *out = fnl_overlay();
    for (int i = 0; i < data->CmdListsCount; i++) {
        const ImDrawList *list = data->CmdLists[i];
        const size_t first_vertex = ui.vertices.count, first_index = ui.indices.count;
        fnl_overlay_vertex *vertices = ui.vertices.add(static_cast<size_t>(list->VtxBuffer.Size));
        uint32_t *indices = ui.indices.add(static_cast<size_t>(list->IdxBuffer.Size));
        if (!vertices || !indices) return; // nothing is drawn
        memcpy(static_cast<void *>(vertices), list->VtxBuffer.Data, static_cast<size_t>(list->VtxBuffer.Size) * sizeof *vertices);
        for (int k = 0; k < list->IdxBuffer.Size; k++) indices[k] = list->IdxBuffer.Data[k];
        for (int k = 0; k < list->CmdBuffer.Size; k++) {
            const ImDrawCmd &command = list->CmdBuffer.Data[k];
            fnl_overlay_draw *draw = ui.draws.add(1);
            if (!draw) return;
            draw->image = image_of(command.GetTexID());
            const float right = std::ceil(command.ClipRect.z), bottom = std::ceil(command.ClipRect.w);
            draw->first_index = static_cast<uint32_t>(first_index) + command.IdxOffset;
            draw->index_count = command.ElemCount;
            draw->first_vertex = static_cast<uint32_t>(first_vertex) + command.VtxOffset;
            draw->x = static_cast<int32_t>(command.ClipRect.x);
            draw->y = static_cast<int32_t>(command.ClipRect.y);
            draw->width = static_cast<uint32_t>(std::fmax(right - static_cast<float>(draw->x), 0));
            draw->height = static_cast<uint32_t>(std::fmax(bottom - static_cast<float>(draw->y), 0));
        }
    }
    out->vertices = ui.vertices.data;
    out->vertex_count = static_cast<uint32_t>(ui.vertices.count);
    out->indices = ui.indices.data;
    out->index_count = static_cast<uint32_t>(ui.indices.count);
    out->draws = ui.draws.data;
    out->draw_count = static_cast<uint32_t>(ui.draws.count);
    ui.images[0] = {&ui.font, ui.font_version};
    memcpy(out->images, ui.images, sizeof ui.images);
}

// ---- over the picture ----

static ImU32 color_of(uint32_t color) { return IM_COL32(color >> 24, color >> 16 & 255, color >> 8 & 255, color & 255); }

void ui_line(float x0, float y0, float x1, float y1, uint32_t color, float width) {
    ImGui::GetBackgroundDrawList()->AddLine(ImVec2(x0, y0), ImVec2(x1, y1), color_of(color), width);
}
void ui_disc(float x, float y, float radius, uint32_t color) { ImGui::GetBackgroundDrawList()->AddCircleFilled(ImVec2(x, y), radius, color_of(color)); }
void ui_triangle(float x0, float y0, float x1, float y1, float x2, float y2, uint32_t color) {
    ImGui::GetBackgroundDrawList()->AddTriangleFilled(ImVec2(x0, y0), ImVec2(x1, y1), ImVec2(x2, y2), color_of(color));
}

// ---- widgets ----

// A label without what is not shown of it.
static ImGuiID name_of(const char *label) {
    uint32_t hash = 2166136261u; // FNV-1a
    for (; *label && !(label[0] == '#' && label[1] == '#'); label++) hash = (hash ^ static_cast<unsigned char>(*label)) * 16777619u;
    return hash;
}

// Notes where the widget stands; returns what it says.
static bool noted(const char *label, bool value) {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    if (!ImGui::IsItemVisible()) {
        if (name_of(label) == ui.sought) ImGui::SetScrollHereY();
        return value;
    }
    place *p = ui.places.add(1);
    if (p) *p = {name_of(label), ImVec2(low.x + 8 * ui.scale, (low.y + high.y) / 2)};
    return value;
}

bool ui_find(const char *label, float *x, float *y) {
    for (size_t i = 0; i < ui.places.count; i++) {
        if (ui.places.data[i].label != name_of(label)) continue;
        *x = std::floor(ui.places.data[i].inside.x);
        *y = std::floor(ui.places.data[i].inside.y);
        return true;
    }
    return false;
}

void ui_seek(const char *label) { ui.sought = label ? name_of(label) : 0; }

static ImGuiCond when_placed() { return ui.relaid ? ImGuiCond_Always : ImGuiCond_Appearing; }
enum { FIXED = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings };

void ui_toolbar(void) {
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(std::floor(2 * ui.scale), std::floor(2 * ui.scale)));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(padding.x, std::floor(padding.y / 2)));
    ImGui::SetNextWindowPos(ImVec2(0, 0));
    ImGui::SetNextWindowSize(ImVec2(ImGui::GetIO().DisplaySize.x, ui.toolbar_height));
    ImGui::Begin("##toolbar", nullptr, FIXED | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
}
float ui_toolbar_end(void) {
    // The line that is begun counts; a window of this height is drawn from the next frame on.
    ui.toolbar_height = ImGui::GetItemRectMax().y + ImGui::GetStyle().WindowPadding.y;
    ImGui::SetWindowSize(ImVec2(ImGui::GetIO().DisplaySize.x, ui.toolbar_height));
    ImGui::End();
    ImGui::PopStyleVar(4);
    return ui.toolbar_height / ui.scale;
}
bool ui_toolbar_button(const char *label, bool on) {
    ui_same_line_if_fits(label);
    ImGui::PushStyleColor(ImGuiCol_Button, on ? ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive) : ImVec4(0, 0, 0, 0));
    const bool pressed = noted(label, ImGui::Button(label));
    ImGui::PopStyleColor();
    return pressed;
}
// As in a menu bar: while one menu is open, a click on another button opens that one. A click on its own button closes it, already when the button goes down.
bool ui_menu(const char *label, bool on) {
    char name[64];
    snprintf(name, sizeof name, "##menu %s", label);
    ui_toolbar_button(label, on);
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax(), clicked = ImGui::GetIO().MouseClickedPos[0];
    const bool hovered = ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenBlockedByPopup);
    if (hovered && ImGui::IsMouseClicked(0)) ui.menu_was_open = ImGui::IsPopupOpen(name);
    if (hovered && ImGui::IsMouseReleased(0) && clicked.x >= low.x && clicked.x < high.x && clicked.y >= low.y && clicked.y < high.y && !ui.menu_was_open) ImGui::OpenPopup(name);
    const float width = ImGui::GetIO().DisplaySize.x, left = std::fmax(0, std::fmin(low.x, width - ui.menu_width));
    ImGui::SetNextWindowPos(ImVec2(left, high.y));
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(width, std::fmax(ImGui::GetIO().DisplaySize.y - high.y, 40)));
    // Menus keep the gaps of other windows.
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(8 * ui.scale, 8 * ui.scale));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(8 * ui.scale, 4 * ui.scale));
    if (!ImGui::BeginPopup(name)) {
        ImGui::PopStyleVar(2);
        return false;
    }
    ui.menu_width = ImGui::GetWindowWidth();
    if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    return true;
}
void ui_menu_end(void) {
    ImGui::EndPopup();
    ImGui::PopStyleVar(2);
}
bool ui_menu_is_open(void) { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup); }

void ui_dock(const char *name, ui_rectangle at) {
    ImGui::SetNextWindowPos(ImVec2(at.x * ui.scale, at.y * ui.scale));
    ImGui::SetNextWindowSize(ImVec2(at.width * ui.scale, at.height * ui.scale));
    ImGui::Begin(name, nullptr, FIXED | ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoFocusOnAppearing);
}
void ui_card(const char *name, ui_rectangle within, float width) {
    const float wide = std::fmin(width, within.width - 16);
    ImGui::SetNextWindowPos(ImVec2((within.x + within.width / 2) * ui.scale, (within.y + within.height / 2) * ui.scale), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
    ImGui::SetNextWindowSizeConstraints(ImVec2(wide * ui.scale, 0), ImVec2(wide * ui.scale, std::fmax(within.height - 16, 40) * ui.scale));
    ImGui::Begin(name, nullptr, FIXED | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoFocusOnAppearing);
}
void ui_corner(const char *name, float right, float bottom, float width) {
    ImGui::SetNextWindowPos(ImVec2(right * ui.scale, bottom * ui.scale), ImGuiCond_Always, ImVec2(1, 1));
    ImGui::SetNextWindowSizeConstraints(ImVec2(width * ui.scale, 0), ImVec2(width * ui.scale, bottom * ui.scale));
    ImGui::Begin(name, nullptr, FIXED | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoFocusOnAppearing);
}
bool ui_dialog(const char *title, bool *open, float width, float height) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos(ImVec2(display.x / 2, display.y / 2), when_placed(), ImVec2(0.5f, 0.5f));
    ImGui::SetNextWindowSize(ImVec2(std::fmin(width * ui.scale, display.x - 8), std::fmin(height * ui.scale, display.y - 8)), when_placed());
    return ImGui::Begin(title, open, ImGuiWindowFlags_NoCollapse);
}
void ui_window_end(void) { ImGui::End(); }
bool ui_tabs(const char *name) { return ImGui::BeginTabBar(name, ImGuiTabBarFlags_FittingPolicyScroll); }
bool ui_tab(const char *label, bool *open, bool front) {
    return noted(label, ImGui::BeginTabItem(label, open, front ? ImGuiTabItemFlags_SetSelected : 0));
}
void ui_tab_end(void) { ImGui::EndTabItem(); }
void ui_tabs_end(void) { ImGui::EndTabBar(); }
bool ui_picture_button(const char *label, uint32_t image, float top, float bottom, float width, float height, bool chosen) {
    ImGui::BeginGroup();
    ImGui::PushID(label);
    ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(chosen ? ImGuiCol_ButtonActive : ImGuiCol_Button));
    const bool pressed = ImGui::ImageButton(id_of(image), ImVec2(width * ui.scale, height * ui.scale), ImVec2(0, top), ImVec2(1, bottom), static_cast<int>(3 * ui.scale));
    ImGui::PopStyleColor();
    ImGui::PopID();
    noted(label, false);
    ImGui::TextUnformatted(label);
    ImGui::EndGroup();
    return pressed;
}
void ui_child(const char *name, float height) { ImGui::BeginChild(name, ImVec2(0, height * ui.scale), height != 0); }
void ui_child_end(void) { ImGui::EndChild(); }

static float list_rest; // height of the lines behind those that were added
void ui_list(const char *name, float shown, uint32_t count, uint32_t *first, uint32_t *end) {
    const float line = ImGui::GetFrameHeightWithSpacing();
    ImGui::BeginChild(name, ImVec2(0, shown * line + 2 * ImGui::GetStyle().WindowPadding.y), true);
    *first = static_cast<uint32_t>(ImGui::GetScrollY() / line);
    if (*first > count) *first = count;
    *end = *first + static_cast<uint32_t>(ImGui::GetWindowHeight() / line) + 2;
    if (*end > count) *end = count;
    list_rest = static_cast<float>(count - *end) * line;
    if (*first > 0) ImGui::Dummy(ImVec2(0, static_cast<float>(*first) * line - ImGui::GetStyle().ItemSpacing.y));
}
void ui_list_end(void) {
    if (list_rest > 0) ImGui::Dummy(ImVec2(0, list_rest - ImGui::GetStyle().ItemSpacing.y));
    ImGui::EndChild();
}

void ui_text(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    ImGui::TextV(format, arguments);
    va_end(arguments);
}
void ui_note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextWrappedV(format, arguments);
    ImGui::PopStyleColor();
    va_end(arguments);
}
void ui_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    ImGui::PushStyleColor(ImGuiCol_Text, ui.dark ? ImVec4(1, 0.6f, 0.35f, 1) : ImVec4(0.7f, 0.22f, 0, 1));
    ImGui::TextWrappedV(format, arguments);
    ImGui::PopStyleColor();
    va_end(arguments);
}
void ui_align_text(void) { ImGui::AlignTextToFramePadding(); }
void ui_separator(void) { ImGui::Separator(); }
void ui_same_line(void) { ImGui::SameLine(); }
void ui_same_line_if_fits(const char *label) {
    const ImGuiStyle &style = ImGui::GetStyle();
    const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    const float wide = ImGui::CalcTextSize(label, nullptr, true).x + 2 * style.FramePadding.x;
    if (ImGui::GetCursorPosY() > ImGui::GetWindowContentRegionMin().y + 1 && ImGui::GetItemRectMax().x + style.ItemSpacing.x + wide <= right) ImGui::SameLine();
}
void ui_item_width(float width) {
    const float room = ImGui::GetContentRegionAvail().x;
    ImGui::SetNextItemWidth(width < 0 ? width * ui.scale : std::fmin(width * ui.scale, std::floor(room * (room < 260 * ui.scale ? 0.42f : 0.6f))));
}
void ui_tooltip(const char *text) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 36);
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}
bool ui_header(const char *label, bool open_first) { return noted(label, ImGui::CollapsingHeader(label, open_first ? ImGuiTreeNodeFlags_DefaultOpen : 0)); }
bool ui_button(const char *label) { return noted(label, ImGui::Button(label)); }
bool ui_checkbox(const char *label, bool *value) { return noted(label, ImGui::Checkbox(label, value)); }
bool ui_radio(const char *label, bool chosen) { return noted(label, ImGui::RadioButton(label, chosen)); }

bool ui_number(const char *label, float *value, float low, float high, const char *format) {
    const float range = high - low;
    if (range > 0 && range < 1e5f) return noted(label, ImGui::SliderFloat(label, value, low, high, format, ImGuiSliderFlags_AlwaysClamp));
    const float speed = std::fmax(std::fabs(*value) * 0.01f, 0.01f);
    return noted(label, ImGui::DragFloat(label, value, speed, low, high, format, ImGuiSliderFlags_AlwaysClamp));
}
bool ui_count(const char *label, uint32_t *value, uint32_t low, uint32_t high) {
    if (high - low <= 64) return ImGui::SliderScalar(label, ImGuiDataType_U32, value, &low, &high, "%u", ImGuiSliderFlags_AlwaysClamp);
    const float speed = std::fmax(static_cast<float>(*value) * 0.01f, 0.2f);
    return ImGui::DragScalar(label, ImGuiDataType_U32, value, speed, &low, &high, "%u", ImGuiSliderFlags_AlwaysClamp);
}
bool ui_color(const char *label, float rgb[3]) { return ImGui::ColorEdit3(label, rgb, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR); }
void ui_focus(void) { ImGui::SetKeyboardFocusHere(); }
bool ui_input(const char *label, char *text, size_t capacity) {
    return noted(label, ImGui::InputText(label, text, capacity, ImGuiInputTextFlags_EnterReturnsTrue));
}
bool ui_combo(const char *label, const char *shown) { const bool open = ImGui::BeginCombo(label, shown);
    return open || noted(label, false); }
bool ui_choice(const char *label, bool chosen) {
    const bool clicked = noted(label, ImGui::Selectable(label, chosen));
    if (chosen) ImGui::SetItemDefaultFocus();
    return clicked;
}
void ui_combo_end(void) { ImGui::EndCombo(); }
void ui_disabled(void) { ImGui::BeginDisabled(); }
void ui_enabled(void) { ImGui::EndDisabled(); }
void ui_plot(const char *label, const float *values, uint32_t count, uint32_t first, float most, float height) {
    ImGui::PlotLines(label, values, static_cast<int>(count), static_cast<int>(first), nullptr, 0, most,
                     ImVec2(ImGui::GetContentRegionAvail().x, height * ui.scale));
}
void ui_bar(float part, const char *text) { ImGui::ProgressBar(part, ImVec2(-1, 0), text); }
bool ui_table(const char *name, int columns, float first) {
    if (!ImGui::BeginTable(name, columns, ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_Resizable)) return false;
    for (int i = 0; i < columns; i++)
        ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, i == 0 ? first : (1 - first) / static_cast<float>(columns - 1));
    return true;
}
void ui_cell(void) { ImGui::TableNextColumn(); }
void ui_table_end(void) { ImGui::EndTable(); }

// ---- a canvas ----

static ImVec2 canvas_origin;

static ImVec2 canvas_place(float x, float y) { return ImVec2(canvas_origin.x + x * ui.scale, canvas_origin.y + y * ui.scale); }

void ui_canvas_begin(const char *name, float width, float height, float shown, ui_canvas *out) {
    ImGui::BeginChild(name, ImVec2(0, shown * ui.scale), true, ImGuiWindowFlags_HorizontalScrollbar);
    canvas_origin = ImGui::GetCursorScreenPos();
    ImGui::Dummy(ImVec2(width * ui.scale, height * ui.scale));
    const ImVec2 low = ImGui::GetWindowDrawList()->GetClipRectMin(), high = ImGui::GetWindowDrawList()->GetClipRectMax(), mouse = ImGui::GetIO().MousePos;
    out->left = (low.x - canvas_origin.x) / ui.scale;
    out->top = (low.y - canvas_origin.y) / ui.scale;
    out->width = (high.x - low.x) / ui.scale;
    out->height = (high.y - low.y) / ui.scale;
    out->hovered = ImGui::IsWindowHovered();
    out->mouse_x = (mouse.x - canvas_origin.x) / ui.scale;
    out->mouse_y = (mouse.y - canvas_origin.y) / ui.scale;
}
void ui_canvas_end(void) { ImGui::EndChild(); }

bool ui_canvas_rect(const char *label, float x, float y, float width, float height, uint32_t color) {
    const ImVec2 low = canvas_place(x, y), high = canvas_place(x + width, y + height);
    ImDrawList *list = ImGui::GetWindowDrawList();
    list->AddRectFilled(low, high, color_of(color));
    const ImVec2 clip_low = list->GetClipRectMin(), clip_high = list->GetClipRectMax();
    const float left = std::fmax(low.x, clip_low.x), right = std::fmin(high.x, clip_high.x), top = std::fmax(low.y, clip_low.y),
                bottom = std::fmin(high.y, clip_high.y);
    if (left >= right || top >= bottom) return false;
    if (label) { // at whole pixels, in it however narrow it is
        float inside = std::floor((left + right) / 2);
        if (inside < left) inside = std::ceil(left);
        place *p = ui.places.add(1);
        if (p) *p = {name_of(label), ImVec2(inside, (top + bottom) / 2)};
    }
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    return mouse.x >= left && mouse.x < right && mouse.y >= top && mouse.y < bottom && ImGui::IsWindowHovered();
}
void ui_canvas_line(float x0, float y0, float x1, float y1, uint32_t color) {
    ImGui::GetWindowDrawList()->AddLine(canvas_place(x0, y0), canvas_place(x1, y1), color_of(color), ui.scale);
}
void ui_canvas_text(float x, float y, float width, uint32_t color, const char *text) {
    const ImVec2 at = canvas_place(x, y), end = canvas_place(x + width, y);
    const ImVec4 clip(at.x, at.y, end.x, at.y + ImGui::GetFontSize());
    ImGui::GetWindowDrawList()->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, color_of(color), text, nullptr, 0, &clip);
}
void ui_key_color(uint32_t rgba, const char *text) {
    const float side = std::floor(ImGui::GetTextLineHeight() * 0.8f), down = std::floor(ImGui::GetTextLineHeight() * 0.1f);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(corner.x, corner.y + down), ImVec2(corner.x + side, corner.y + down + side), color_of(rgba));
    ImGui::Dummy(ImVec2(side, ImGui::GetTextLineHeight()));
    ImGui::SameLine(0, 4 * ui.scale);
    ImGui::TextUnformatted(text);
}
bool ui_clicked(void) { return ImGui::IsMouseClicked(0); }
void ui_hint(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    ImGui::BeginTooltip();
    ImGui::TextV(format, arguments);
    ImGui::EndTooltip();
    va_end(arguments);
}
float ui_width_left(void) { return ImGui::GetContentRegionAvail().x / ui.scale; }
float ui_height_left(void) { return ImGui::GetContentRegionAvail().y / ui.scale; }
