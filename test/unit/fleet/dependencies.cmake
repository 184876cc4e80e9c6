set(fleet_test_dependencies nlohmann_json::nlohmann_json)
