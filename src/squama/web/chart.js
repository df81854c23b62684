// A plot by ECharts. It is given its options as they came: read through Vue's proxies they take several times as long.
import { echarts } from "nicegui-echart";
import { toRaw } from "vue";

// What is said of the cell under the pointer: its place along the axes, its end, and the figures that it has.
function told({ axes, ends, lines }, { value }) {
  const sides = axes.map(([symbol, unit, low, step], i) => {
    return `${symbol} = ${Number((low + value[i] * step).toPrecision(3))} ${unit}`.trim();
  });
  const known = lines.filter((line) => !line.match(/\d+(?=})/g).some((place) => value[place] == null));
  const figures = known.map((line) => line.replace(/{(\d+)}/g, (_, place) => value[place]));
  return [sides.join(", "), `<b>${ends[value[2]]}</b>`, ...figures].join("<br>");
}

// What is said of the points of lines under the pointer: the twist, and each line's value, with their units.
function read([across, up], points) {
  const figure = (value, unit) => `${Number(value.toPrecision(3))} ${unit}`;
  const rows = points.map(({ marker, seriesName, value }) => {
    return `${marker}${echarts.format.encodeHTML(seriesName)}: <b>${figure(value[1], up)}</b>`;
  });
  return [figure(points[0].value[0], across), ...rows].join("<br>");
}

export default {
  props: { options: Object, renderer: String },
  emits: ["picked"],
  template: `<div class="chart" role="img"></div>`,
  mounted() {
    this.chart = echarts.init(this.$el, null, { renderer: this.renderer });
    this.chart.on("click", ({ value, seriesId }) => this.$emit("picked", { value, seriesId }));
    this.watched = new ResizeObserver(() => this.chart.resize());
    this.watched.observe(this.$el);
    this.draw();
  },
  beforeUnmount() {
    this.watched.disconnect();
    this.chart.dispose();
  },
  watch: { options: "draw" },
  methods: {
    draw() {
      const { words, ...options } = toRaw(this.options);
      // functions do not come from the server: this one is made here from words that do
      const said = (found) => (words.units ? read(words.units, found) : told(words, found));
      if (words) options.tooltip = { ...options.tooltip, formatter: said };
      // lines that are there no more go only with all the others
      const lines = options.series.length;
      this.chart.setOption(options, { notMerge: lines !== this.lines });
      this.lines = lines;
    },
  },
};
