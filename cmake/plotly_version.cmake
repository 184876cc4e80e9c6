# Plotly (MIT): the package of the npm registry, and the sha256 of the plotly.min.js in it.
set(plotly_package "plotly.js-dist-min@4.1.2")
set(plotly_sha256 "2f645d1bade8182fce161b7f10f89402f8b315805250ff4a94672a28d23c390a")
