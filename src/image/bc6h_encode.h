/* SPDX-License-Identifier: MIT */
/** What the encoders share. Private to this folder. */
#ifndef FNL_IMAGE_BC6H_ENCODE_H
#define FNL_IMAGE_BC6H_ENCODE_H

#include "image/bc6h.h"

/* Encoders work with whole endpoints and any index; these two make of it what is packed. */

/** Swaps the ends of regions whose anchor would have an index with its highest bit set. */
void bc6h_anchor_indices(struct bc6h_fields *fields);
/** Endpoints become differences to the first where the mode stores those. */
void bc6h_store_deltas(struct bc6h_fields *fields);

/** The other way round, for what is unpacked. */
void bc6h_whole_endpoints(struct bc6h_fields *fields, bool is_signed);

/** `texels` are finite. */
struct bc6h_block bc6h_encode_best(const struct bc6h_params *params, const float texels[16][3]);

#endif
