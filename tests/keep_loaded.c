/* SPDX-License-Identifier: MIT */
/*
 * Linked into sanitized tests: libraries stay loaded to the end. Memory that a Vulkan driver or layer keeps in its globals
 * then still counts as reachable; once unloaded, the leak checker would blame the program for it.
 */
__attribute__((visibility("default"))) int dlclose(void *handle);

int dlclose(void *handle) {
    (void)handle;
    return 0;
}
