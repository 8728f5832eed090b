/* SPDX-License-Identifier: MIT */
/* Acceleration structures: of VK_KHR_acceleration_structure, for VK_KHR_ray_query. */
#include "gpu/gpu_internal.h"

/* One structure's geometry; it points into itself and must not be moved. */
struct description {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureBuildRangeInfoKHR range;
};

static void describe(const struct gpu_structure_input *input, struct description *out) {
    *out = (struct description){
        .geometry = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
                     .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                     .flags = VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR},
        .info = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
                          (input->changes ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR
                                          : VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR),
                 .geometryCount = 1,
                 .pGeometries = &out->geometry},
        .range.primitiveCount = input->count};
    if (input->of_instances) {
        out->geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
        out->geometry.flags = 0;
        out->geometry.geometry.instances = (VkAccelerationStructureGeometryInstancesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR, .data.deviceAddress = input->instances};
        out->info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
        out->info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    } else
        out->geometry.geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
            .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
            .vertexData.deviceAddress = input->positions,
            .vertexStride = 3 * sizeof(float),
            .maxVertex = MAX(input->vertex_count, 1u) - 1,
            .indexType = VK_INDEX_TYPE_UINT32,
            .indexData.deviceAddress = input->indices};
}

uint64_t gpu_scratch_padding(const gpu_device *device) { return device->scratch_alignment - 1; }

struct gpu_structure_sizes gpu_structure_sizes(gpu_device *device, const struct gpu_structure_input *input) {
    struct description d;
    describe(input, &d);
    VkAccelerationStructureBuildSizesInfoKHR sizes = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    device->vk.GetAccelerationStructureBuildSizesKHR(device->handle, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &d.info,
                                                     &input->count, &sizes);
    return (struct gpu_structure_sizes){sizes.accelerationStructureSize, align_up(sizes.buildScratchSize, device->scratch_alignment),
                                        align_up(sizes.updateScratchSize, device->scratch_alignment)};
}

static struct gpu_retired retired_structure(const struct gpu_structure *structure) {
    return (struct gpu_retired){.structure = structure->handle,
                                .buffer = structure->buffer.handle,
                                .allocation = structure->buffer.allocation,
                                .sampled_index = GPU_NO_INDEX,
                                .storage_index = GPU_NO_INDEX,
                                .srgb_index = GPU_NO_INDEX};
}

fnl_result gpu_structure_create(gpu_device *device, const char *name, bool of_instances, uint64_t size, struct gpu_structure *out) {
    *out = (struct gpu_structure){0};
    TRY(gpu_structure_buffer_create(device, name, size, &out->buffer));
    VkAccelerationStructureCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
                                                 .buffer = out->buffer.handle,
                                                 .size = size,
                                                 .type = of_instances ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                                                      : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR};
    const VkResult made = device->vk.CreateAccelerationStructureKHR(device->handle, &info, NULL, &out->handle);
    const fnl_result result = gpu_check(device, made, "'%s': vkCreateAccelerationStructureKHR", name);
    if (result != FNL_OK) {
        gpu_memory_count_structure(device, out->buffer.allocation.size, false);
        gpu_buffer_destroy(device, &out->buffer);
        *out = (struct gpu_structure){0};
        return result;
    }
    gpu_name(device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)out->handle, name);
    VkAccelerationStructureDeviceAddressInfoKHR address = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR, .accelerationStructure = out->handle};
    out->address = device->vk.GetAccelerationStructureDeviceAddressKHR(device->handle, &address);
    return FNL_OK;
}

void gpu_structure_destroy(gpu_device *device, struct gpu_structure *structure) {
    if (structure->handle) {
        struct gpu_retired item = retired_structure(structure);
        gpu_last_use_remove(&device->last_uses, false, (uint64_t)structure->buffer.handle);
        gpu_retire(device, &item);
    }
    *structure = (struct gpu_structure){0};
}

/* ---- compacted sizes ---- */

fnl_result gpu_structure_queries_create(gpu_device *device, uint32_t count, struct gpu_structure_queries *out) {
    *out = (struct gpu_structure_queries){0};
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                  .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                  .queryCount = count};
    const VkResult made = device->vk.CreateQueryPool(device->handle, &info, NULL, &out->handle);
    if (made != VK_SUCCESS) {
        gpu_retire_cancel(device);
        out->handle = VK_NULL_HANDLE;
        return gpu_check(device, made, "vkCreateQueryPool");
    }
    gpu_name(device, VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)out->handle, "compacted sizes");
    device->vk.ResetQueryPool(device->handle, out->handle, 0, count);
    out->count = count;
    return FNL_OK;
}

void gpu_structure_queries_destroy(gpu_device *device, struct gpu_structure_queries *queries) {
    if (queries->handle)
        gpu_retire(device, &(struct gpu_retired){.queries = queries->handle,
                                                 .sampled_index = GPU_NO_INDEX,
                                                 .storage_index = GPU_NO_INDEX,
                                                 .srgb_index = GPU_NO_INDEX});
    *queries = (struct gpu_structure_queries){0};
}

bool gpu_structure_queries_read(gpu_device *device, const struct gpu_structure_queries *queries, uint64_t *sizes) {
    const VkResult result = device->vk.GetQueryPoolResults(device->handle, queries->handle, 0, queries->count, queries->count * sizeof *sizes,
                                                           sizes, sizeof *sizes, VK_QUERY_RESULT_64_BIT);
    gpu_check(device, result, "vkGetQueryPoolResults");
    return result == VK_SUCCESS;
}

/* ---- commands ---- */

static void build(struct gpu_commands *commands, const struct gpu_structure_build *builds, uint32_t count, VkDeviceAddress scratch) {
    enum { BATCH = 32 };
    struct description described[BATCH];
    VkAccelerationStructureBuildGeometryInfoKHR infos[BATCH];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BATCH];
    for (uint32_t first = 0; first < count; first += BATCH) {
        const uint32_t here = MIN(count - first, (uint32_t)BATCH);
        for (uint32_t i = 0; i < here; i++) {
            const struct gpu_structure_build *b = &builds[first + i];
            describe(&b->input, &described[i]);
            infos[i] = described[i].info;
            infos[i].mode = b->update ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
            infos[i].srcAccelerationStructure = b->update ? b->to->handle : VK_NULL_HANDLE;
            infos[i].dstAccelerationStructure = b->to->handle;
            infos[i].scratchData.deviceAddress = scratch + b->scratch;
            ranges[i] = &described[i].range;
        }
        commands->device->vk.CmdBuildAccelerationStructuresKHR(commands->handle, here, infos, ranges);
    }
}

void gpu_build_structures(struct gpu_commands *commands, const struct gpu_structure_build *builds, uint32_t count,
                          const struct gpu_buffer *scratch) {
    if (!commands->handle || count == 0) return;
    build(commands, builds, count, align_up(scratch->address, commands->device->scratch_alignment));
}

void gpu_measure_structures(struct gpu_commands *commands, const struct gpu_structure_queries *queries, uint32_t first,
                            const struct gpu_structure *structures, uint32_t count) {
    if (!commands->handle) return;
    for (uint32_t i = 0; i < count; i++)
        commands->device->vk.CmdWriteAccelerationStructuresPropertiesKHR(commands->handle, 1, &structures[i].handle,
                                                                         VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                                                         queries->handle, first + i);
}

void gpu_compact_structure(struct gpu_commands *commands, const struct gpu_structure *from, const struct gpu_structure *to) {
    if (!commands->handle) return;
    const VkCopyAccelerationStructureInfoKHR info = {.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
                                                     .src = from->handle,
                                                     .dst = to->handle,
                                                     .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR};
    commands->device->vk.CmdCopyAccelerationStructureKHR(commands->handle, &info);
}
