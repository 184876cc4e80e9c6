set(report_test_dependencies model nlohmann_json::nlohmann_json)
