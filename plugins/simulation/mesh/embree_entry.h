/// What the simulator looks up in the library that knows Embree.
#pragma once

namespace loopline::simulation {

class MeshCaster;
struct TriangleMesh;

using EmbreeEntry = MeshCaster* (*)(const TriangleMesh* mesh);
constexpr const char* embree_entry_name = "loopline_make_embree_caster";

}  // namespace loopline::simulation
