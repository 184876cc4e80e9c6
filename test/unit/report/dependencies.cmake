set(report_test_dependencies workflow design model nlohmann_json::nlohmann_json)
