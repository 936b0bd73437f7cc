/// Memory in large pages.
#pragma once

namespace loopline {

/// From now on the heap of this process grows in pages of 2 MB, where the system has them. A run touches tens
/// of megabytes once; getting these 4 KB at a time takes longer than reading the log does. Costs at most one
/// such page more than is needed.
void use_large_pages();

/// What is free in the heap goes back to the system: a picture takes more memory than the estimate that it
/// shows, and should not take it beside what the estimate needed.
void give_back_free_memory();

}  // namespace loopline
