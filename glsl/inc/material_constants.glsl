// Specialisation constants of every shader that evaluates a material (src/passes/material.rs).
layout(constant_id = 0) const uint HAS_BASE_TEXTURE = 0;
layout(constant_id = 1) const uint HAS_NORMAL_TEXTURE = 0;
layout(constant_id = 2) const uint HAS_EMISSION_TEXTURE = 0;
layout(constant_id = 3) const uint HAS_MASK = 0;
layout(constant_id = 4) const uint HAS_UV0 = 0;
layout(constant_id = 5) const uint HAS_UV1 = 0;
layout(constant_id = 6) const uint HAS_TANGENTS = 0;
layout(constant_id = 7) const uint HAS_COLORS = 0;
