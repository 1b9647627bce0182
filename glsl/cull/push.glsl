// A draw range and its part of the buffers (src/passes/cull.rs).
layout(push_constant) uniform Push {
    uint frame_count;
    uint capacity;         // frames that the buffers have room for
    uint first_cluster;
    uint clusters;
    uint words;            // of 32 clusters each
    uint first_word;
    uint first_triangle;
    uint end_triangle;
    uint first_draw;
    uint draws;            // of a frame, at most: runs of clusters do not touch each other
    uint list_frames;      // frames whose draws one indirect draw makes
    uint piece_frames;     // frames of a workgroup of list.comp
    uint pieces_of_list;
    uint first_piece;
    uint pieces;           // of a view
    uint first_list;
    uint lists;            // of a view
} push;

uint first_word_of(uint view, uint frame) { return push.first_word + (view * push.capacity + frame) * push.words; }
