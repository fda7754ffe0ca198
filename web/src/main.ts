import "@oicl/openbridge-webcomponents/dist/openbridge.css";
import "./style/theme.css";
import "./app";
