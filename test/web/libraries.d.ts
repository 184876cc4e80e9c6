// The libraries of the pages as far as their checks know them: anything.
declare module "preact";
declare module "preact/hooks";
declare module "uplot";
declare module "three";
declare module "three/loaders/*";
declare const Plotly: any;
