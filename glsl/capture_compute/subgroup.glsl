// What a workgroup that is one subgroup waits and counts by.
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require

// All invocations are here before one goes on, and see what others wrote to shared memory.
void meet() { subgroupBarrier(); }

// Of the invocations that want a place in a row, in their order: how many come before this one, how many there are.
uvec2 places(bool wanted) {
    uvec4 who = subgroupBallot(wanted);
    return uvec2(subgroupBallotExclusiveBitCount(who), subgroupBallotBitCount(who));
}
