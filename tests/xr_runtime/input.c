/* SPDX-License-Identifier: MIT */
/* Paths and actions. What an action stands for is told by its suggested bindings: select and trigger are the one button, squeeze, grip and menu the other. */
#include "runtime.h"

#include <string.h>

static const char *const hand_paths[HANDS] = {"/user/hand/left", "/user/hand/right"};

static XRAPI_ATTR XrResult XRAPI_CALL callStringToPath(XrInstance instance, const char *text, XrPath *out) {
    ENTER();
    if (!find_object(instance, KIND_INSTANCE)) return mistake(XR_ERROR_HANDLE_INVALID, "the instance is none");
    if (!text || *text != '/' || strlen(text) >= XR_MAX_PATH_LENGTH) return mistake(XR_ERROR_PATH_FORMAT_INVALID, "a path");
    for (uint64_t i = 0; i < rt.paths_count; i++)
        if (strcmp(rt.paths[i], text) == 0) return *out = i + 1, XR_SUCCESS;
    if (rt.paths_count == PATHS) return XR_ERROR_PATH_COUNT_EXCEEDED;
    strcpy(rt.paths[rt.paths_count], text);
    *out = ++rt.paths_count;
    return XR_SUCCESS;
}

static const char *path_text(XrPath path) { return path >= 1 && path <= rt.paths_count ? rt.paths[path - 1] : NULL; }

static XRAPI_ATTR XrResult XRAPI_CALL callPathToString(XrInstance instance, XrPath path, uint32_t capacity, uint32_t *count, char *out) {
    ENTER();
    (void)instance;
    const char *text = path_text(path);
    if (!text) return mistake(XR_ERROR_PATH_INVALID, "the path is none");
    *count = (uint32_t)strlen(text) + 1;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
    memcpy(out, text, *count);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateActionSet(XrInstance instance, const XrActionSetCreateInfo *info, XrActionSet *out) {
    ENTER();
    struct object *parent = find_object(instance, KIND_INSTANCE);
    if (!parent) return mistake(XR_ERROR_HANDLE_INVALID, "the instance is none");
    CHECK_TYPE(info, XR_TYPE_ACTION_SET_CREATE_INFO);
    if (!info->actionSetName[0] || !info->localizedActionSetName[0]) return mistake(XR_ERROR_NAME_INVALID, "a name is empty");
    *out = (XrActionSet)new_object(KIND_ACTION_SET, parent);
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callDestroyActionSet(XrActionSet set) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(set, KIND_ACTION_SET);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the action set is none");
    destroy_object(object);
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateAction(XrActionSet set, const XrActionCreateInfo *info, XrAction *out) {
    ENTER();
    struct object *parent = find_object(set, KIND_ACTION_SET);
    if (!parent) return mistake(XR_ERROR_HANDLE_INVALID, "the action set is none");
    CHECK_TYPE(info, XR_TYPE_ACTION_CREATE_INFO);
    if (rt.attached) return mistake(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the set is attached");
    for (const char *c = info->actionName; *c; c++)
        if (!strchr("abcdefghijklmnopqrstuvwxyz0123456789-_.", *c)) return mistake(XR_ERROR_PATH_FORMAT_INVALID, "the name '%s'", info->actionName);
    if (!info->actionName[0] || !info->localizedActionName[0]) return mistake(XR_ERROR_NAME_INVALID, "a name is empty");
    struct object *object = new_object(KIND_ACTION, parent);
    if (!object) return XR_ERROR_LIMIT_REACHED;
    object->action.type = info->actionType;
    strcpy(object->action.name, info->actionName);
    *out = (XrAction)object;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callDestroyAction(XrAction action) {
    const XrResult injected = enter(__func__ + 4); /* what is destroyed is gone even then */
    struct object *object = find_object(action, KIND_ACTION);
    if (!object) return mistake(XR_ERROR_HANDLE_INVALID, "the action is none");
    destroy_object(object);
    return injected;
}

static XRAPI_ATTR XrResult XRAPI_CALL callSuggestInteractionProfileBindings(XrInstance instance, const XrInteractionProfileSuggestedBinding *info) {
    ENTER();
    (void)instance;
    CHECK_TYPE(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    if (rt.attached) return mistake(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the set is attached");
    if (!path_text(info->interactionProfile) || info->countSuggestedBindings == 0) return mistake(XR_ERROR_VALIDATION_FAILURE, "no profile or no bindings");
    for (uint32_t i = 0; i < info->countSuggestedBindings; i++) {
        const char *text = path_text(info->suggestedBindings[i].binding);
        struct object *action = find_object(info->suggestedBindings[i].action, KIND_ACTION);
        if (!action || !text) return mistake(XR_ERROR_HANDLE_INVALID, "binding %u", i);
        const bool is_gaze = strcmp(text, "/user/eyes_ext/input/gaze_ext/pose") == 0;
        if (is_gaze != (strcmp(path_text(info->interactionProfile), "/interaction_profiles/ext/eye_gaze_interaction") == 0) || (is_gaze && !rt.ext_gaze))
            return mistake(XR_ERROR_PATH_UNSUPPORTED, "%s of %s", text, path_text(info->interactionProfile));
        if (is_gaze && action->action.type != XR_ACTION_TYPE_POSE_INPUT) return mistake(XR_ERROR_ACTION_TYPE_MISMATCH, "the gaze is a pose");
        action->action.is_gaze |= is_gaze;
        if (is_gaze) continue;
        if (strncmp(text, "/user/hand/left/", 16) != 0 && strncmp(text, "/user/hand/right/", 17) != 0) return mistake(XR_ERROR_PATH_UNSUPPORTED, "%s", text);
    }
    note("bindings for %s", path_text(info->interactionProfile));
    rt.bound_profiles++;
    return XR_SUCCESS;
}

#define SESSION(handle)                                                                                                     \
    do {                                                                                                                    \
        XrResult lost_;                                                                                                     \
        ENTER();                                                                                                            \
        if (!find_object(handle, KIND_SESSION)) return mistake(XR_ERROR_HANDLE_INVALID, "the session is none");             \
        if (is_lost(&lost_)) return lost_;                                                                                  \
    } while (0)

static XRAPI_ATTR XrResult XRAPI_CALL callAttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo *info) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    if (rt.attached) return mistake(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "once is all");
    for (uint32_t i = 0; i < info->countActionSets; i++)
        if (!find_object(info->actionSets[i], KIND_ACTION_SET)) return mistake(XR_ERROR_HANDLE_INVALID, "action set %u is none", i);
    rt.attached = true;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callSyncActions(XrSession session, const XrActionsSyncInfo *info) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_ACTIONS_SYNC_INFO);
    if (!rt.attached) return mistake(XR_ERROR_ACTIONSET_NOT_ATTACHED, "no action set is attached");
    return rt.state == XR_SESSION_STATE_FOCUSED ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

static uint32_t hand_of(XrPath path) {
    const char *text = path_text(path);
    for (uint32_t i = 0; text && i < HANDS; i++)
        if (strcmp(text, hand_paths[i]) == 0) return i;
    return HANDS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateActionSpace(XrSession session, const XrActionSpaceCreateInfo *info, XrSpace *out) {
    SESSION(session);
    CHECK_TYPE(info, XR_TYPE_ACTION_SPACE_CREATE_INFO);
    struct object *action = find_object(info->action, KIND_ACTION);
    if (!action || action->action.type != XR_ACTION_TYPE_POSE_INPUT) return mistake(XR_ERROR_ACTION_TYPE_MISMATCH, "the action has no pose");
    if (hand_of(info->subactionPath) == HANDS && !action->action.is_gaze) return mistake(XR_ERROR_PATH_UNSUPPORTED, "of which hand?");
    struct object *object = new_object(KIND_SPACE, (struct object *)session);
    if (!object) return XR_ERROR_LIMIT_REACHED;
    object->space.action = action;
    object->space.hand = hand_of(info->subactionPath);
    object->space.pose = info->poseInActionSpace;
    *out = (XrSpace)object;
    return XR_SUCCESS;
}

#define STATE(info, wanted, out, out_type)                                                                                  \
    CHECK_TYPE(info, XR_TYPE_ACTION_STATE_GET_INFO);                                                                        \
    CHECK_TYPE(out, out_type);                                                                                              \
    const struct object *action = find_object((info)->action, KIND_ACTION);                                                 \
    const uint32_t side = hand_of((info)->subactionPath);                                                                   \
    if (!action || action->action.type != (wanted)) return mistake(XR_ERROR_ACTION_TYPE_MISMATCH, "the action is of another type"); \
    if (side == HANDS && !action->action.is_gaze) return mistake(XR_ERROR_PATH_UNSUPPORTED, "of which hand?");              \
    const struct hand_row *hand = rt.state == XR_SESSION_STATE_FOCUSED ? hand_now(side) : NULL;                             \
    (out)->isActive = hand != NULL

static XRAPI_ATTR XrResult XRAPI_CALL callGetActionStateBoolean(XrSession session, const XrActionStateGetInfo *info, XrActionStateBoolean *out) {
    SESSION(session);
    STATE(info, XR_ACTION_TYPE_BOOLEAN_INPUT, out, XR_TYPE_ACTION_STATE_BOOLEAN);
    out->currentState = hand && (strcmp(action->action.name, "grab") == 0 ? hand->squeeze : hand->select);
    out->changedSinceLastSync = XR_FALSE;
    out->lastChangeTime = rt.now;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetActionStateFloat(XrSession session, const XrActionStateGetInfo *info, XrActionStateFloat *out) {
    SESSION(session);
    STATE(info, XR_ACTION_TYPE_FLOAT_INPUT, out, XR_TYPE_ACTION_STATE_FLOAT);
    out->currentState = hand && (strcmp(action->action.name, "grab") == 0 ? hand->squeeze : hand->select) ? 1 : 0;
    out->changedSinceLastSync = XR_FALSE;
    out->lastChangeTime = rt.now;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetActionStatePose(XrSession session, const XrActionStateGetInfo *info, XrActionStatePose *out) {
    SESSION(session);
    STATE(info, XR_ACTION_TYPE_POSE_INPUT, out, XR_TYPE_ACTION_STATE_POSE);
    const struct gaze_row *gaze = gaze_now();
    if (action->action.is_gaze) out->isActive = rt.state == XR_SESSION_STATE_FOCUSED && gaze && gaze->active;
    return XR_SUCCESS;
}

PFN_xrVoidFunction input_function(const char *name) {
    FUNCTION(StringToPath, name)
    FUNCTION(PathToString, name)
    FUNCTION(CreateActionSet, name)
    FUNCTION(DestroyActionSet, name)
    FUNCTION(CreateAction, name)
    FUNCTION(DestroyAction, name)
    FUNCTION(SuggestInteractionProfileBindings, name)
    FUNCTION(AttachSessionActionSets, name)
    FUNCTION(SyncActions, name)
    FUNCTION(CreateActionSpace, name)
    FUNCTION(GetActionStateBoolean, name)
    FUNCTION(GetActionStateFloat, name)
    FUNCTION(GetActionStatePose, name)
    return NULL;
}
