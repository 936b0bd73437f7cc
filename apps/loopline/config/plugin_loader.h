/// Plugin libraries, by MRPT's own loader: loaded once, never unloaded, duplicates and other versions refused.
#pragma once

#include <string>
#include <vector>

#include "api/importer.h"
#include "api/module.h"
#include "api/simulator.h"

namespace loopline {

/// Loads every plugin library of the folder beside the program (../lib/loopline), in name order, and returns the paths.
/// Throws CommandError(exit_configuration) with a sentence for one that can't be used.
std::vector<std::string> load_plugins();
/// The same for one library.
void load_plugin(const std::string& path);

/// Names (ModuleInfo::name) of all modules, of all map builders, of all importers and of all simulators, sorted.
std::vector<std::string> known_modules();
std::vector<std::string> known_map_builders();
std::vector<std::string> known_importers();
std::vector<std::string> known_simulators();
/// Null if there is none of that name.
Module::Ptr make_module(const std::string& name);
MapBuilder::Ptr make_map_builder(const std::string& name);
Importer::Ptr make_importer(const std::string& name);
Simulator::Ptr make_simulator(const std::string& name);

}  // namespace loopline
