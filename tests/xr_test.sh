#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# xr_test.sh BUILD: `fanal xr` against a scripted OpenXR runtime (tests/xr_runtime) that checks every call. Exit status 77: built without OpenXR.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" xr --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal xr' (Debian: libopenxr-dev)"; exit 77; }
work=$(mktemp -d)
failures=0
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export XR_RUNTIME_JSON=$build/tests/xr_runtime/xr_runtime.json XDG_CACHE_HOME=$work/cache
plain=(--shading forward --lists all --shadows off --exposure 5 --resolution 1 --msaa 1 --aa none) # what costs least
fail() { echo "FAILED: $name: $*" >&2; head -c 2000 "$name.out" >&2; failures=$((failures + 1)); }

# run STATUS NAME SCENE OPTION…, with the script on stdin. The runtime must have no complaint.
run() {
    local wanted=$1 status leaks=1
    name=$2
    shift 2
    cat >"$name.txt"
    [[ " $* " != *' --validate '* ]] || leaks=0 # sanitized: the layer keeps memory, and is unloaded
    ASAN_OPTIONS=detect_leaks=$leaks FANAL_XR_SCRIPT=$name.txt FANAL_XR_LOG=$name.log timeout 900 "$fanal" xr "$@" --stats "$name.json" >"$name.out" 2>&1
    status=$?
    [ $status = "$wanted" ] || fail "exit status $status in place of $wanted"
    ! grep MISTAKE "$name.log" || fail "the runtime found a mistake"
    [ "$wanted" != 0 ] || grep -q 'instance destroyed, 0 mistakes' "$name.log" || fail "the instance was not destroyed"
}
# is EXPRESSION: true of the statistics.
is() { [ "$(jq "$1" "$name.json" 2>&1)" = true ] || fail "not so: $1; $(jq -c "${1%%[=<>]*}" "$name.json" 2>&1 | head -c 300)"; }
says() { grep -q -- "$1" "$name.out" || fail "it does not say '$1'"; }
picture() { "$build/tests/xr_picture" "$name.json" . "$@" >"$name.out" 2>&1 || fail "pictures: $*"; rm -f ./*.raw views-*; }

# shows VR-13: poses at simulation, at rendering and at the compositor on a scripted sine: each is nearer to the truth
# shows VR-18: a session reaches FOCUSED, 300 frames without a validation message, poses and fields of view as given, clean exit, losses
# shows VR-19: the visibility mask is read, 3.125 % of the view; none with a count of 0; a change event rebuilds it
# shows VR-20: depth handed over, reversed and forward; without the extension
# shows VR-21: misses are counted against the headset's refresh
# ---- 300 frames with all that a runtime may send ----
run 0 long builtin:onetile "${plain[@]}" --frames 300 --validate <<'END'
size 24 24
sway 0.2 1
turn 20 1.3
cost xrWaitSwapchainImage 2
cost xrReleaseSwapchainImage 1
at 50 stall 40
at 60 unknown_event
at 61 events_lost
at 62 profile
at 70 mask 0 0.5
at 80 mask 1 0
at 100 hide 5
at 150 pause 3
END
is '.frames.rendered == 300'
is '.frames.missed == 4' # 40 ms and the frame's own 6 are five periods of 11.1 ms
is '(.times.period_ms - 1000 / 90 | fabs) < 1e-3 and .times.budget_ms == .times.period_ms'
is '.sessions.connections == 1 and .sessions.lost == 0'
is '.sessions.states == ["idle","ready","synchronized","visible","focused","visible","synchronized","visible","focused","visible","synchronized","stopping","idle","ready","synchronized","visible","focused","visible","synchronized","stopping","idle","exiting"]'
is '.prediction.frames > 250 and .prediction.rendered.metres > 0 and .prediction.simulated.metres > 1.3 * .prediction.rendered.metres'
is '.prediction.simulated.radians > 1.3 * .prediction.rendered.radians'
awk '$1 == "prediction" && NF > 8 { for (i = 2; i < 9; i++) if (i != 5) sum[i] += $i; n++ }
    END { exit !(n > 290 && sum[2] > sum[3] && sum[3] > sum[4] && sum[6] > sum[7] && sum[7] > sum[8] && sum[8] > 0) }' long.log || fail "predictions do not get better from stage to stage"
is '.mask.reads == 4 and .mask.changes == 2 and .mask.frames == 300'
is '.last.views[0].hidden > 0.03125 / 8 and .last.views[1].hidden == 0' # triangles at half their places, and none
grep -q '^a picture that nobody sees' long.log && fail "a picture was handed over while nothing was shown"

# ---- pictures and depth are those of a frame with the runtime's eyes ----
run 0 usual builtin:onetile --frames 2 --exposure 5 --resolution 1 --msaa 1 --aa none --validate <<'END'
head 0.1 1.7 0.2 10
save 3 1 .
END
! grep -qi 'warning.*\(field of view\|mm apart\)' usual.out || fail "VR-22: a warning about a usual headset"
is '(.last.views | map(.hidden - 0.03125 | fabs) | max) < 1e-6' # what Monado hides
is '.depth and .format == "R8G8B8A8_SRGB" and .space == "stage"'
grep -q 'depth from 0 to 1, nearZ inf, farZ 0.05' usual.log || fail "depth is not reversed"
picture 3 builtin:onetile rgba reversed ev=5
run 0 smooth builtin:onetile --frames 2 --exposure 5 --resolution 0.5 <<'END'
save 3 1 .
END
rm -f depth-* # at edges a sample's depth is not the pixel's
picture 3 builtin:onetile rgba none ev=5 msaa=auto aa=auto
run 0 samples builtin:onetile "${plain[@]}" --frames 2 --msaa 4 --depth forward --near 0.1 --resolution 0.5 <<'END'
formats 50 126
size 33 29
save 3 1 .
END
grep -q 'depth from 0 to 1, nearZ 0.1, farZ inf' samples.log || fail "depth is not forward"
is '.last.views[0].size == [17, 15]'
grep -q 'layers 1 depth 1 rect 17x15' samples.log || fail "the part is not that which was rendered"
rm -f depth-*
picture 3 builtin:onetile bgra none ev=5 shading=forward lists=all shadows=off msaa=4
# shows VR-22: the field of view changes while the scene is shown, and eyes are where nobody's are
run 0 comfort builtin:onetile "${plain[@]}" --frames 5 <<'END'
size 16 16
eye 0 -0.05 0 0 0 0
eye 1 0.05 0 0 0 0
at 3 fov 0.9
at 4 fov 0.9
END
[ "$(grep -c 'warning: the field of view changes' comfort.out)" = 1 ] || fail "VR-22: no warning, or several, about another field of view"
[ "$(grep -c 'warning: the eyes are 100 mm apart' comfort.out)" = 1 ] || fail "VR-22: no warning about eyes 100 mm apart"
[ "$(grep -c 'warning: --world-scale' comfort.out)" = 0 ] || fail "VR-22: a warning about a usual scale"
run 0 scale builtin:onetile "${plain[@]}" --frames 3 --depth forward --world-scale 3 <<'END'
head 0.1 1.7 0.2 10
save 3 1 .
END
[ "$(grep -c 'warning: --world-scale 3 makes a scene in meters appear smaller' scale.out)" = 1 ] || fail "VR-22: no warning, or several, about another scale"
! grep -q 'mm apart' scale.out || fail "the eyes are apart as people's are, whatever the scale"
grep -q 'depth from 0 to 1, nearZ 0.05, farZ inf' scale.log || fail "the runtime is told of another near distance than the room's"
is '.world_scale == 3 and (.last.views[0].near_distance - 0.15 | fabs) < 1e-6'
is '(.last.views | map(.position) | [.[0][0] - .[1][0], .[0][1] - .[1][1], .[0][2] - .[1][2]] | map(. * .) | add | sqrt) as $apart | ($apart - 3 * 0.064 | fabs) < 1e-4'
rm -f depth-*
picture 3 builtin:onetile rgba none ev=5 shading=forward lists=all shadows=off
run 0 four builtin:onetile "${plain[@]}" --frames 2 --depth forward --validate <<'END'
views 4
size 16 16 2
size 16 16 3
fov -20 15 -14 19 2
fov -15 20 -14 19 3
eye 2 -0.032 0 0 4 0
eye 3 0.032 0 0 -4 0
save 3 1 .
END
is '.views == 4'
picture 3 builtin:onetile rgba forward ev=5 shading=forward lists=all shadows=off
run 0 bare builtin:onetile "${plain[@]}" --frames 2 <<'END'
without XR_KHR_composition_layer_depth
without XR_KHR_visibility_mask
no_stage
formats 97
END
is '(.depth | not) and .mask.reads == 0 and .space == "local" and .format == "R16G16B16A16_SFLOAT"'
grep -q 'layers 1 depth 0' bare.log || fail "no picture without depth"
run 0 off builtin:onetile "${plain[@]}" --frames 1 --depth off --no-mask --no-input --stereo --space local <<<'views 4'
is '.views == 2 and (.depth | not) and .mask.reads == 0 and .space == "local"'

# ---- where the user stands; recentring; resolution by frame time ----
run 0 place builtin:onetile "${plain[@]}" --frames 12 --eye 1,2,3 --look-at 5,2,3 <<'END'
no_stage
head 0.5 1.7 -0.3 25
at 6 recenter 0.4 0.2 70
END
is '.sessions.recentered == 1'
stands() { is "[.last.views[0,1].position] | ((.[0][0] + .[1][0]) / 2 - $1 | fabs) < 1e-4 and ((.[0][1] + .[1][1]) / 2 - $2 | fabs) < 1e-4 and ((.[0][2] + .[1][2]) / 2 - $3 | fabs) < 1e-4"; }
stands 1 2 3
is '.last.views[0] | (.target[0] - .position[0]) > 0.999 * (((.target[0] - .position[0]) | . * .) + ((.target[2] - .position[2]) | . * .) | sqrt)'
# After a recenter, the user keeps the position he walked to: 0.4 m right and 0.4 m ahead in LOCAL, turned by -115 degrees to face +X.
run 0 walked builtin:onetile "${plain[@]}" --frames 12 --eye 1,2,3 --look-at 5,2,3 <<'END'
no_stage
head 0.5 1.7 -0.3 25
at 3 walk 0.9 1.7 -0.7
at 6 recenter 0.4 0.2 70
END
is '.sessions.recentered == 1'
stands 1.19348 2 3.53157
run 0 slow builtin:onetile "${plain[@]}" --frames 12 --resolution auto --budget 0.001 </dev/null
is '.resolution.scale == 0.5 and .resolution.changes == 1 and .frames.over_budget > 8 and .last.views[0].size == [24, 24]'
run 0 fast builtin:onetile "${plain[@]}" --frames 12 --resolution auto --budget 100000 </dev/null
is '.resolution.scale == 1 and .resolution.changes == 0 and .frames.over_budget == 0'

# ---- controllers ----
cat >lamp.gltf <<'END'
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"], "scene": 0, "scenes": [{"nodes": [0, 1]}],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5}]}},
 "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 1.5, -2]}, {"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
END
run 0 hands lamp.gltf "${plain[@]}" --studio off --frames 20 --eye 0,1.6,0 --look-at 0,1.6,-1 <<'END'
size 96 96
hand left 4 0 1.5 0 0 0 0 0
hand left 6 0 1.5 0 0 0 0 1
hand left 8 0.5 1.75 0 0 0 0 1
hand left 9 0.5 1.75 0 0 0 0 0
hand left 10 -0.05 1.57 0 -20 -5 0 0
hand right 12 0 1.5 0 0 -45 1 0
save 11 1 .
hand right 14 0 1.5 0 0 -45 0 0
hand right 15 0 1.5 0 0 45 1 0
hand right 16 0 1.5 0 0 45 0 0
END
cp color-11-0.raw ray.raw
is '.input.teleports == 1 and .input.grabs == 1 and .input.light_moves == 3'
is '.input.light | (.[0] - 0.5 | fabs) < 1e-4 and (.[1] - 1.75 | fabs) < 1e-4 and (.[2] + 2 | fabs) < 1e-4'
is '[.last.views[0,1].position] | ((.[0][0] + .[1][0]) / 2 | fabs) < 1e-4 and (.[0][1] - 1.6 | fabs) < 1e-4 and (.[0][2] + 1.5 | fabs) < 1e-4'

run 0 handless lamp.gltf "${plain[@]}" --studio off --frames 10 --no-input --eye 0,1.6,0 --look-at 0,1.6,-1 <<'END'
size 96 96
hand left 4 0 1.5 0 0 0 0 0
save 11 1 .
END
changed=$(cmp -l ray.raw color-11-0.raw | wc -l)
[ "$changed" -gt 30 ] && [ "$changed" -lt 2000 ] || fail "$changed bytes show the ray of the hand"
rm -f ./*.raw

# ---- where the eyes look: foveation follows, from the frame in which they are found until they are lost ----
# shows VR-11: foveation by the eyes that the headset tells; in the middle where it does not
fovea=(--shading coarse --lists all --shadows off --exposure 5 --resolution 1 --no-mask --set coarse.size=4 --set coarse.fovea=6 --set coarse.fovea-far=12 --eye 0,1.6,0 --look-at 0,1.6,-1)
fovea_picture() { picture "$1" builtin:onetile rgba reversed ev=5 shading=coarse lists=all shadows=off coarse.size=4 coarse.fovea=6 coarse.fovea-far=12; }
run 0 gaze builtin:onetile "${fovea[@]}" --frames 8 --validate <<'END'
size 96 96
sway 0.2 1
turn 20 1.3
gaze 5 20 -15
save 9 1 .
END
is '.gaze.frames == 5'
# 20 degrees to the left of the head and 15 down, 2 m away
is '[.last.views | (map(.position), map(.target)) | transpose | map(add / 2)] as [$p, $t] | .gaze.point as $g | [0, 1, 2] | map($t[.] - $p[.]) as $ahead | atan2($ahead[0]; -$ahead[2]) as $yaw
    | ($g[0] - $p[0]) as $x | ($g[1] - $p[1]) as $y | ($g[2] - $p[2]) as $z | ($x * $x + $y * $y + $z * $z | sqrt) as $far
    | ($far - 2 | fabs) < 1e-4 and ($y / $far + (15 * 3.14159265 / 180 | sin) | fabs) < 1e-3 and (atan2($x; -$z) - $yaw + 20 * 3.14159265 / 180 | fabs) < 2e-2'
cp color-9-0.raw gaze.kept
fovea_picture 9
for kind in lost none no-extension no-option; do
    option=()
    [ $kind != no-option ] || option=(--no-gaze)
    run 0 "gaze-$kind" builtin:onetile "${fovea[@]}" "${option[@]}" --frames 8 <<END
size 96 96
sway 0.2 1
turn 20 1.3
$(case $kind in
    lost) printf 'gaze 4 20 -15\ngaze 5 off\ngaze 6 20 -15\ngaze 7 20 -15 guessed\ngaze 8 20 -15\ngaze 9 lost\n' ;;
    no-extension) printf 'gaze 5 20 -15\nwithout XR_EXT_eye_gaze_interaction\n' ;;
    no-option) printf 'gaze 5 20 -15\n' ;;
    esac)
save 9 1 .
END
    is ".gaze.frames == $([ $kind = lost ] && echo 3 || echo 0) and .gaze.point == null"
    cmp -s gaze.kept color-9-0.raw && fail "the picture is that with a gaze"
    [ $kind = lost ] || cmp middle.kept color-9-0.raw || fail "foveation is not in the middle"
    [ $kind != lost ] || cp color-9-0.raw middle.kept
    [ $kind != lost ] || fovea_picture 9
    rm -f color-* depth-* views-*
done
run 0 gaze-hands lamp.gltf "${fovea[@]}" --frames 8 <<'END'
size 16 16
gaze 1 20 -15
hand right 4 0 1.5 0 0 -45 1 0
hand right 6 0 1.5 0 0 -45 0 0
END
is '.gaze.frames > 5 and .input.teleports == 1'
run 0 gaze-fails builtin:onetile "${fovea[@]}" --no-input --frames 2 <<'END'
size 16 16
gaze 1 20 -15
fail xrCreateActionSpace 1 XR_ERROR_RUNTIME_FAILURE
END
says 'xrCreateActionSpace: XR_ERROR_RUNTIME_FAILURE: goes on without the gaze'
run 0 gaze-unused builtin:onetile "${plain[@]}" --frames 2 <<<'gaze 1 20 -15'
is '.gaze.frames == 0' # nothing goes by it
! grep -q eye_gaze gaze-unused.log || fail "the eyes are asked for nothing"

# ---- poses, gazes, masks and controllers that are none: the frame goes on without them, and one warning says which ----
for what in pose later mask-nan mask-far mask-part gaze hand; do
    script=() option=("${plain[@]}") warning='it is not used'
    case $what in
    pose) script=('at 4 bad_pose 2' 'at 8 bad_pose 1') ;;
    later) script=('at 1 bad_pose 3') ;;
    mask-nan) script=('at 4 mask 0 nan') warning='goes on without the visibility mask, whose triangles are broken' ;;
    mask-far) script=('at 4 mask 1 1e7') warning='goes on without the visibility mask, whose triangles are broken' ;;
    mask-part) script=('at 4 mask 0 inf' 'at 6 mask 0 0') warning='goes on without the visibility mask, whose triangles are broken' ;;
    gaze) script=('gaze 3 20 -15' 'gaze 5 nan 0' 'gaze 6 20 -15') option=("${fovea[@]}") ;;
    hand) script=('hand left 4 0 1.5 0 0 0 1 1' 'hand left 5 0 1.5 0 nan 0 1 1' 'hand left 6 nan 1.5 0 0 0 0 0') ;;
    esac
    run 0 "bad-$what" builtin:onetile "${option[@]}" --frames 8 <<<"$(printf '%s\n' 'size 16 16' "${script[@]}")"
    is '.frames.rendered == 8 and .sessions.connections == 1'
    [ "$(grep -c "warning.*$warning" "$name.out")" = 1 ] || fail "no warning, or several, of a bad $what"
    ! grep -q 'field of view\|error' "$name.out" || fail "something else is blamed"
    [ $what != gaze ] || is '.gaze.frames > 4 and .gaze.frames < 8'
done

# ---- losses: the session is begun anew each time ----
run 0 losses builtin:onetile "${plain[@]}" --frames 24 <<'END'
size 16 16
at 4 lose_session
at 8 lose_instance
at 12 session_loss_pending
at 16 instance_loss_pending
fail xrEndFrame 20 XR_ERROR_SESSION_LOST
fail xrCreateSession 6 XR_ERROR_INSTANCE_LOST
fail xrBeginFrame 28 XR_SESSION_LOSS_PENDING
END
is '.sessions.lost == 7 and .sessions.connections == 8 and .frames.rendered == 24'
says 'begun anew'
run 2 hopeless builtin:onetile "${plain[@]}" --frames 3 <<<'fail xrCreateSession 0 XR_ERROR_SESSION_LOST'
says 'lost 6 times in a row'

# ---- each function fails once. What the picture needs ends the command, with the function's name and the result; the rest is left out ----
for function in CreateInstance GetSystem EnumerateViewConfigurations EnumerateViewConfigurationViews EnumerateEnvironmentBlendModes \
    GetVulkanGraphicsRequirements2KHR CreateVulkanInstanceKHR GetVulkanGraphicsDevice2KHR CreateVulkanDeviceKHR CreateSession \
    EnumerateReferenceSpaces CreateReferenceSpace EnumerateSwapchainFormats CreateSwapchain EnumerateSwapchainImages BeginSession PollEvent WaitFrame \
    BeginFrame LocateViews AcquireSwapchainImage WaitSwapchainImage ReleaseSwapchainImage EndFrame RequestExitSession EndSession; do
    run 2 "fail-$function" builtin:onetile "${plain[@]}" --frames 1 <<<"fail xr$function 1 XR_ERROR_RUNTIME_FAILURE"
    says "error: xr$function: XR_ERROR_RUNTIME_FAILURE"
    grep -q "injected xr$function" "$name.log" || fail "it was not called"
    [ ! -e "$name.json" ] || fail "statistics were written"
done
# One after the other, in a session each: the first to fail is the last of its kind to be called.
{
    echo 'size 16 16'
    echo 'hand left 1 0 1.5 0 0 0 0 0'
    frame=4
    for function in GetInstanceProperties GetSystemProperties GetVisibilityMaskKHR; do echo "fail xr$function 1 XR_ERROR_RUNTIME_FAILURE"; done
    for function in StringToPath CreateActionSet CreateAction SuggestInteractionProfileBindings CreateActionSpace AttachSessionActionSets SyncActions \
        GetActionStatePose GetActionStateBoolean; do
        echo "fail xr$function 1 XR_ERROR_RUNTIME_FAILURE"
        echo "at $((frame += 5)) lose_session"
    done
} >failing
run 0 optional builtin:onetile "${plain[@]}" --frames 36 <failing
for function in StringToPath CreateActionSet CreateAction SuggestInteractionProfileBindings CreateActionSpace AttachSessionActionSets SyncActions \
    GetActionStatePose GetActionStateBoolean GetInstanceProperties GetSystemProperties GetVisibilityMaskKHR; do
    says "warning: xr$function: XR_ERROR_RUNTIME_FAILURE"
done
run 0 ends builtin:onetile "${plain[@]}" --frames 1 <<'END'
fail xrDestroySwapchain 1 XR_ERROR_RUNTIME_FAILURE
fail xrDestroySession 1 XR_ERROR_RUNTIME_FAILURE
fail xrWaitSwapchainImage 1 XR_TIMEOUT_EXPIRED
fail xrWaitSwapchainImage 2 XR_TIMEOUT_EXPIRED
END
says 'warning: xrDestroySwapchain'
says 'warning: xrDestroySession'
grep -q 'injected xrWaitSwapchainImage' ends.log || fail "no image was waited for"

# ---- headsets that cannot be used ----
run 2 none builtin:onetile <<<no_system
says 'has no headset now'
run 2 mono builtin:onetile <<<'views 1'
says 'has no stereo views'
run 2 formats builtin:onetile <<<'formats 126'
says 'takes none of the image formats'
run 2 vulkan builtin:onetile <<<'without XR_KHR_vulkan_enable2'
says 'cannot take pictures from Vulkan'
name=missing
XR_RUNTIME_JSON=$work/nothing.json "$fanal" xr builtin:onetile >missing.out 2>&1 && fail "it runs without a runtime"
says 'no OpenXR runtime was found'
name=arguments
"$fanal" xr builtin:onetile --resolution 2 >arguments.out 2>&1 && fail "a bad number was taken"
says 'resolution'

[ $failures = 0 ] || { echo "$failures failures" >&2; exit 1; }
