// Number of an invocation in a dispatch whose workgroups lie in rows, as many of which as one dimension may have.
uint invocation() {
    return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
}
