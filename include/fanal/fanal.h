/* SPDX-License-Identifier: MIT */
/** Everything except the Vulkan import (fanal/vulkan.h). */
#ifndef FANAL_FANAL_H
#define FANAL_FANAL_H

#include "fanal/base.h"
#include "fanal/camera.h"
#include "fanal/compositor.h"
#include "fanal/decal.h"
#include "fanal/device.h"
#include "fanal/energy.h"
#include "fanal/environment.h"
#include "fanal/frame.h"
#include "fanal/gbuffer.h"
#include "fanal/image.h"
#include "fanal/instance.h"
#include "fanal/legend.h"
#include "fanal/light.h"
#include "fanal/light_kinds.h"
#include "fanal/lights.h"
#include "fanal/mesh.h"
#include "fanal/probe.h"
#include "fanal/options.h"
#include "fanal/overlay.h"
#include "fanal/pixel.h"
#include "fanal/renderer.h"
#include "fanal/scene.h"
#include "fanal/scene_ids.h"
#include "fanal/scene_query.h"
#include "fanal/shading.h"
#include "fanal/shading_options.h"
#include "fanal/shadows.h"
#include "fanal/stage.h"
#include "fanal/stats.h"
#include "fanal/stereo.h"
#include "fanal/trace.h"
#include "fanal/values.h"

#endif
