/// Every section that an .ini may have, with its parameters at their defaults: what `loopline describe`
/// shows.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/importer.h"
#include "api/simulator.h"
#include "config/experiment.h"

namespace loopline {

enum class SectionKind { host, module, map_builder, scenario, import_file };

struct CatalogueEntry {
    SectionKind kind;
    ModuleInfo info;
    ParameterTable table;
};

/// The host's sections, then the modules, then the map builders of all plugins, each kind in order of name,
/// then the sections of scenarios in the order of the simulator, and those of files that importers read
/// beside logs.
class Catalogue {
 public:
    /// Loads the plugins.
    Catalogue();
    const std::vector<CatalogueEntry>& entries() const { return entries_; }
    const CatalogueEntry* find(const std::string& name) const;
    std::vector<std::string> names() const;

 private:
    void add(SectionKind kind, const Configurable::Ptr& owner);
    void add_sections(SectionKind kind, const std::vector<ParameterTable>& tables);

    std::unique_ptr<Experiment> defaults_;  ///< that the host's tables are bound to
    std::vector<Configurable::Ptr> owners_;
    std::vector<CatalogueEntry> entries_;
};

/// What the catalogue, or one entry of it, looks like.
std::string describe_all_as_text(const Catalogue& catalogue, std::size_t width);
std::string describe_as_text(const CatalogueEntry& entry, std::size_t width);
std::string describe_all_as_markdown(const Catalogue& catalogue);
std::string describe_as_markdown(const CatalogueEntry& entry);
/// Of an experiment: without the sections of other files.
std::string describe_all_as_ini(const Catalogue& catalogue);

}  // namespace loopline
