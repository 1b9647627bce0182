// Lists one indirect draw for each run of neighbouring clusters that a view of a frame sees, in the order of frames and clusters:
// the order, and with it every tie of depth, is always the same. A workgroup takes a piece of a list, a view of a few frames. It
// first counts its draws; a second dispatch, which knows what the pieces before it have counted, writes them.
#version 460
#extension GL_GOOGLE_include_directive : require
const uint THREADS = 64;
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint WRITES = 0;
layout(constant_id = 1) const uint CLEARS_REST = 0;  // devices without drawIndirectCount draw what is not used, too
layout(constant_id = 2) const uint FAN = 1;          // triangles that one is drawn as
layout(constant_id = 3) const uint CLUSTER = 1;      // triangles of a cluster
layout(constant_id = 4) const uint COUNTS = 0;       // triangles that are drawn

struct Draw { uint index_count; uint instance_count; uint first_index; int vertex_offset; uint first_instance; };

layout(set = 0, binding = 0, std430) readonly buffer Seen { uint seen[]; };
layout(set = 0, binding = 1, std430) buffer Pieces { uint piece_draws[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Draws { Draw draws[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Lists { uint list_draws[]; };
layout(set = 0, binding = 4, std430) buffer Count { uint count[2]; };
#include "cull/push.glsl"
#include "inc/count.glsl"

shared uint parts[THREADS], others[THREADS], triangles;

// Words of the piece, one frame's after another's.
uint word_base;
uint word_at(uint j) { return seen[word_base + j]; }

// Bits of the word's clusters that begin a run.
uint starts_in(uint j) {
    uint before = j % push.words == 0 ? 0 : word_at(j - 1) >> 31, word = word_at(j);
    return word & ~(word << 1 | before);
}

// The cluster of its frame behind the run that begins with cluster c of word j.
uint run_end(uint j, uint c) {
    uint gaps = ~word_at(j) & 0xffffffffu << c;
    while (gaps == 0 && (j + 1) % push.words != 0) gaps = ~word_at(++j);
    return min(32 * (j % push.words) + (gaps == 0 ? 32 : findLSB(gaps)), push.clusters);
}

// Sum of shared values before that of an invocation.
uint sum_before(uint part) {
    uint sum = 0;
    for (uint i = 0; i < part; ++i) sum += parts[i];
    return sum;
}

void write(uint slot, uint frame, uint j, uint c) {
    uint cluster = 32 * (j % push.words) + c, triangle = push.first_triangle + CLUSTER * cluster;
    uint end = min(push.first_triangle + CLUSTER * run_end(j, c), push.end_triangle);
    draws[slot] = Draw(3 * FAN * (end - triangle), 1, 3 * FAN * triangle, 0, frame << 16 | cluster);
    if (COUNTS != 0) atomicAdd(triangles, end - triangle);
}

void main() {
    uint me = gl_LocalInvocationID.x, view = gl_WorkGroupID.y;
    uint list = gl_WorkGroupID.x / push.pieces_of_list, piece = gl_WorkGroupID.x % push.pieces_of_list;
    uint first_frame = list * push.list_frames, end_frame = min(first_frame + push.list_frames, push.frame_count);
    uint from = min(first_frame + piece * push.piece_frames, end_frame), to = min(from + push.piece_frames, end_frame);
    uint words = (to - from) * push.words, share = (words + THREADS - 1) / THREADS;
    uint begin = min(me * share, words), end = min(begin + share, words);
    word_base = first_word_of(view, from);

    uint runs = 0;
    for (uint j = begin; j < end; ++j) runs += bitCount(starts_in(j));
    parts[me] = runs;
    uint first_piece = push.first_piece + view * push.pieces + list * push.pieces_of_list;
    if (WRITES == 0) {
        barrier();
        if (me == 0) piece_draws[first_piece + piece] = sum_before(THREADS);
        return;
    }

    // What all pieces of the list count, and those before this one.
    uint all_ = 0, before = 0;
    for (uint i = me; i < push.pieces_of_list; i += THREADS) {
        uint counted = piece_draws[first_piece + i];
        all_ += counted;
        before += i < piece ? counted : 0;
    }
    others[me] = before;
    if (me == 0) triangles = 0;
    barrier();
    uint slot = push.first_draw + (view * push.capacity + first_frame) * push.draws, free = slot + sum_before(me);
    for (uint i = 0; i < THREADS; ++i) free += others[i];
    for (uint j = begin; j < end; ++j)
        for (uint starts = starts_in(j); starts != 0; starts &= starts - 1)
            write(free++, from + j / push.words, j, findLSB(starts));
    barrier();
    others[me] = all_;
    barrier();
    uint listed = 0;
    for (uint i = 0; i < THREADS; ++i) listed += others[i];
    if (me == 0 && piece == 0) list_draws[push.first_list + view * push.lists + list] = listed;
    if (COUNTS != 0 && me == 0) add_to_count(triangles);
    if (CLEARS_REST == 0) return;
    uint most = (end_frame - first_frame) * push.draws;
    for (uint i = listed + piece * THREADS + me; i < most; i += push.pieces_of_list * THREADS)
        draws[slot + i] = Draw(0, 0, 0, 0, 0);
}
